"""What everything stands on: units, arguments, values that compare, tables, whole files, dates, the version."""
