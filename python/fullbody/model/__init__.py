"""The nouns: shapes and bodies, states, what a system is and what acts in it."""
