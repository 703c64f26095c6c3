# SPDX-License-Identifier: Apache-2.0
"""A DDS domain that no other program on this machine uses, claimed as by vdrive::process.

As a program it prints the domain, and keeps it until standard input ends.
"""
import os
import socket
import sys

FIRST_DOMAIN = 20
DOMAINS = 80


def claim_domain():
    """Return a domain and the socket that keeps it."""
    for offset in range(DOMAINS):
        domain = FIRST_DOMAIN + (os.getpid() + offset) % DOMAINS
        port = 7400 + 250 * domain
        claim = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            claim.bind(("", port))
        except OSError:
            claim.close()
            continue
        # Participants may now share the port. Connected to a port that never sends, this socket takes none of their
        # messages.
        claim.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        claim.connect(("127.0.0.1", port + 9))
        return domain, claim
    raise SystemExit("every DDS domain for tests is in use")


if __name__ == "__main__":
    number, kept = claim_domain()
    print(number, flush=True)
    sys.stdin.read()
