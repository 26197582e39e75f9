"""Runs as files and as tables of other libraries."""
