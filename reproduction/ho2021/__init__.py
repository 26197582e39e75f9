"""Everything that Ho, Wold, Conway & Poursina (2021) show, computed again and compared with the printed values."""
