"""Numbers of a table that another tool recorded: what its columns and its time stamps allow, and no more."""

from benchtool.tables.answer import TableAnswer, analyze_table
from benchtool.tables.columns import TableQuestion

__all__ = ["TableAnswer", "TableQuestion", "analyze_table"]
