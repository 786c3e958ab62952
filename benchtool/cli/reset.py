"""`benchtool reset`."""

from __future__ import annotations

from benchtool.bench.session import open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary.roles import Role


def reset(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Clear a latched fault, such as that of a host that vanished; nothing is enabled."""
    output = Output(as_json=as_json)
    with open_session(profile, link, note=output.note, instruments=False) as session:
        drive = session.drive
        drive.connect()
        before, code = drive.state(), drive.optional_number(Role.ERROR_CODE)
        if before is State.FAULT:
            drive.reset_fault()
        after = drive.state()
    error = None if code is None else f"0x{code:04X}"
    was_in_fault = before is State.FAULT
    output.line(
        f"{before.value} ({error or 'no error code'}), now {after.value}"
        if was_in_fault
        else f"no fault: {after.value}"
    )
    output.document({"before": before.value, "error_code": error, "after": after.value})
    return 0
