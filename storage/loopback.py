"""Which addresses only programs of this machine reach."""

import ipaddress


def is_loopback(host: str) -> bool:
    """Whether only programs of this machine reach it; an IPv6 address may stand in brackets."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")).is_loopback
    except ValueError:
        return False
