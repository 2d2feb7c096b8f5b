"""The command line: parse, call, exit code. One file a command."""

from assetpipe.cli.shell import main

__all__ = ["main"]
