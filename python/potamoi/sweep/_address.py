"""Addresses that are talked to: TLS, or the loopback."""

import ipaddress
from urllib.parse import urlsplit


class Refused(ValueError):
    """An address over which others could read or change a sweep."""


def is_loopback(host):
    """Whether a host is this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check(address, whose):
    """Refuses an address that is neither TLS nor the loopback's; `whose` it is, for the error."""
    try:
        parts = urlsplit(address)
        scheme, host, _ = parts.scheme, parts.hostname, parts.port
    except ValueError:
        scheme = host = None
    if host and (scheme == "tls" or (scheme == "tcp" and is_loopback(host))):
        return
    raise Refused(f"{whose} {address}: expected tls://HOST:PORT, or tcp://127.0.0.1:PORT: who reaches a port "
                  "of Dask without TLS runs any program there")
