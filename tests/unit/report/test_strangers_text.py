"""Names and words of strangers' files do not control a terminal, and can be written."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from assetpipe.errors import InputError, Location
from assetpipe.findings import Finding, Severity
from assetpipe.report.escaping import escape
from assetpipe.report.json import to_json
from assetpipe.report.terminal import show_findings

SPELT = {
    "\x1b]0;title\x07": r"\x1b]0;title\x07",
    "\x9b31m": r"\x9b31m",
    "a\rb": r"a\rb",
    "gnp.\u202eexe": r"gnp.\u202eexe",
    "\ud800": r"\ud800",
    "two\tlines\nof ä → 日本": "two\tlines\nof ä → 日本",
}


@pytest.mark.parametrize("text", SPELT)
def test_messages_spell_out_what_terminals_obey(text: str) -> None:
    error = InputError(f"'{text}' is no number", location=Location(Path("a")))
    assert str(error) == f"a: '{SPELT[text]}' is no number"
    finding = Finding("AP102", Severity.ERROR, text, hint=text)
    assert (finding.message, finding.hint) == (SPELT[text], SPELT[text])
    to_json(finding.as_dict()).encode()


def test_names_are_escaped_for_a_terminal_only() -> None:
    finding = Finding("AP102", Severity.ERROR, "[bold]", link="\x9b[red]").as_dict()
    assert finding["link"] == "\x9b[red]"
    out = io.StringIO()
    show_findings(Console(file=out, width=200), [finding])
    assert r"link '\x9b[red]': [bold]" in out.getvalue()
    assert escape("[red]\x1b") == r"\[red]\x1b"
