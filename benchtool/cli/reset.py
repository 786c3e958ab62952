"""`benchtool reset`."""

from __future__ import annotations

from benchtool.bench import open_session
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import StateError
from benchtool.protocol import State
from benchtool.protocol.canopen import NmtCommand
from benchtool.protocol.dictionary import Role


def reset(
    profile: options.Profile = "zhu2011",
    link: options.Link = "emulated",
    as_json: options.Json = False,
) -> int:
    """Clear a latched fault, such as that of a host that vanished, and start a node that was stopped (NMT).

    Nothing is enabled.
    """
    output = Output(as_json=as_json)
    with open_session(profile, link, note=output.note, instruments=False) as session:
        drive = session.drive
        try:
            drive.connect()
        except StateError:
            if not drive.is_stopped:
                raise
            drive.link.nmt(NmtCommand.START)
            drive.connect()
            output.note("the drive was in NMT state stopped and was started")
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
