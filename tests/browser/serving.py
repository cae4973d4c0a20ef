"""The dashboard on a free port of this machine, in a thread, for a workspace that a test makes of rows."""

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from werkzeug.serving import make_server

from dashboard.app import make_app
from dashboard.server import Listening, guarded
from dashboard.view import Site
from storage.workspace import Workspace


@contextmanager
def serving(workspace: Workspace, sites: Mapping[str, Site]) -> Iterator[str]:
    """Serve a workspace as ``tiltwatch dashboard`` does, but for its server, which a thread cannot stop at once.

    Gives the address without a slash at its end.
    """
    application = guarded(make_app(workspace, sites).server, Listening(port=0))
    server = make_server("127.0.0.1", 0, application, threaded=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join(timeout=10.0)
