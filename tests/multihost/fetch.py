"""Prints the beginning of a web page: ``python -m tests.multihost.fetch URL``."""

import sys
import urllib.request

if __name__ == "__main__":
    with urllib.request.urlopen(sys.argv[1], timeout=60.0) as answer:
        print(answer.read(200).decode())
