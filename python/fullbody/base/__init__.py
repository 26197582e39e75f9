"""The base of all other rooms: units, arguments, values that compare, tables, whole files, dates, the version."""
