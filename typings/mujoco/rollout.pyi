# MuJoCo's wheel carries no type information for its compiled module: every name is Any.
from typing import Any

def __getattr__(name: str) -> Any: ...
