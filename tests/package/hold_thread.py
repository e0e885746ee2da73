"""Holds one thread of a process still until it is ended itself: hold_thread.py PID THREAD_NAME. As a debugger would."""
import ctypes
import os
import pathlib
import sys

PTRACE_SEIZE, PTRACE_INTERRUPT, WALL = 0x4206, 0x4207, 0x40000000
libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]

process, name = sys.argv[1:]
threads = [int(task.name) for task in pathlib.Path(f"/proc/{process}/task").iterdir()
           if (task / "comm").read_text().strip() == name]
if len(threads) != 1:
    sys.exit(f"process {process} has {len(threads)} threads called {name}")
for request in (PTRACE_SEIZE, PTRACE_INTERRUPT):
    if libc.ptrace(request, threads[0], None, None) != 0:
        sys.exit(f"cannot hold it: error {ctypes.get_errno()}")
# Our own end would let the thread go on; and a process can only end when who holds its thread takes note.
ended = False
while not ended:
    status = os.waitpid(threads[0], WALL)[1]
    ended = os.WIFEXITED(status) or os.WIFSIGNALED(status)
