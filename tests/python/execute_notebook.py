"""Execute a notebook in an empty folder and write it with its outputs.

`python tests/python/execute_notebook.py NOTEBOOK [OUT]`; without OUT the notebook is overwritten.
The tests start this as a process of its own: the Jupyter libraries warn about one another.
"""

from __future__ import annotations

import sys
import tempfile

import nbclient
import nbformat
from jupyter_client import KernelManager

if __name__ == "__main__":
    path, out = sys.argv[1], sys.argv[-1]
    manager = KernelManager(kernel_name="python3")
    manager.kernel_spec.argv[0] = sys.executable
    notebook = nbformat.read(path, as_version=4)
    client = nbclient.NotebookClient(
        notebook, km=manager, timeout=900, startup_timeout=300, record_timing=False
    )
    with tempfile.TemporaryDirectory() as folder:
        client.execute(cwd=folder)
    notebook.metadata["language_info"] = {"name": "python"}
    nbformat.write(notebook, out)
