"""Parameters of a drive: as a file, moved between dictionaries, written all or none, kept over a reset."""
