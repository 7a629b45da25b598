"""The command line: words in, one table or one JSON object out.

Nothing imports this package, and it computes no motion: every command calls the same public
functions a script would. `main` picks the command without importing anything heavy; one module
per command holds its options (a dataclass) and `run(options) -> Outcome`.
"""
