"""Reports: a build's record as JSON, a table, JUnit or SARIF.

Every report is made from the record (``report.json``), so that a stored one can be
shown again in any form.
"""

from assetpipe.report.json import write_json
from assetpipe.report.junit import write_junit
from assetpipe.report.sarif import write_sarif

__all__ = ["write_json", "write_junit", "write_sarif"]
