"""Everything that Ho, Wold, Conway & Poursina (2021) show, run again and laid beside what they print."""
