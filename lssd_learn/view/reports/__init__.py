"""Pages that need nothing else: shapes that turn and change, charts, tables, the methods in words."""
