"""Ho, Wold, Poursina & Conway (2022), A&A 665, A43: rotational fission."""
