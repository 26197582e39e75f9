"""Runs as files and tables of other libraries."""
