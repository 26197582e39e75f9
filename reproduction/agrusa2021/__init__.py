"""Agrusa et al. (2021), Icarus 370, 114624: the attitude of Dimorphos after an impact."""
