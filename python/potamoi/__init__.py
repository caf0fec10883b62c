"""Potamoi in Python: bit-exact NumPy models of units, and the program's files as arrays and tables."""

from .exponential import Exponential
from .reducer import Reducer
from .registers import RegisterMap
from .trace import Trace

__all__ = ["Exponential", "Reducer", "RegisterMap", "Trace"]
