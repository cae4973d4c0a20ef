"""Arrays that several stages of a process read at the same time, loaded once."""

import threading
from typing import Final
from weakref import WeakValueDictionary

from numpy.typing import NDArray

from storage.artifacts import ArtifactRef, Number, get_array
from storage.workspace import Workspace

_KNOWN: Final[WeakValueDictionary[tuple[str, str], NDArray[Number]]] = WeakValueDictionary()
_LOADING: Final = threading.Lock()


def share_array(ws: Workspace, ref: ArtifactRef) -> NDArray[Number]:
    """Load a stored array, or give the one that somebody in this process holds already; it must not be written to.

    Raises
    ------
    StorageError
        If it is absent or damaged.
    """
    key = (ws.place, ref.name)
    with _LOADING:
        array = _KNOWN.get(key)
        if array is None:
            array = _KNOWN[key] = get_array(ws, ref)
    return array
