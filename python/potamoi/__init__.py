"""Bit-exact NumPy model of the exponentials that Potamoi generates as hardware."""

from .exponential import Exponential

__all__ = ["Exponential"]
