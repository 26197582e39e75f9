"""All computations of Ho, Wold, Conway & Poursina (2021), repeated and compared with the printed values."""
