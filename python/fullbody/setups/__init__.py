"""Systems from published numbers and from TOML."""
