"""How much a number differs from record to record, by the record itself."""
