"""The base of all other subpackages: units, arguments, values that compare, tables, whole files, dates, the version."""
