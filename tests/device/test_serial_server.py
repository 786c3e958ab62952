"""The tests of the emulated drive on a serial line, run with the C library.

Left out is what a test does to the emulated bench itself: more lines than one, threads, ports that fail.
"""

from __future__ import annotations

from tests.wire.test_serial_server import (
    test_a_command_that_ends_operation_switches_the_power_stage_off,
    test_a_fault_is_an_event_with_its_tick,
    test_a_host_that_is_heard_keeps_the_motor_running,
    test_a_new_host_starts_afresh,
    test_a_setpoint_is_taken_whole_or_not_at_all,
    test_a_stopped_drive_says_so,
    test_a_whole_request_that_makes_no_sense_is_rejected,
    test_an_object_that_cannot_be_read_is_not_opened_and_a_reset_forgets_an_upload,
    test_chunks_beyond_the_end_are_refused_with_one_message,
    test_every_command_is_confirmed_at_once,
    test_frames_come_together_from_pieces,
    test_heartbeats_follow_the_drives_time,
    test_identity_is_that_of_the_dictionary,
    test_nothing_else_keeps_it_running,
    test_nothing_that_is_sent_ends_the_server,
    test_reads_are_answered_by_bytes_or_by_the_reason,
    test_setpoints_are_taken_in_their_order_and_never_twice,
    test_setpoints_count_in_operational_only,
    test_what_is_damaged_or_unknown_is_dropped_and_counted,
    test_writes_are_taken_or_refused_with_the_reason,
)
from tests.wire.test_serial_stream import (
    test_every_accepted_configuration_is_another_schema_with_counts_of_its_own,
    test_records_stand_on_the_grid_of_their_stride,
    test_scaled_records_hold_steps_and_what_does_not_fit_is_marked,
    test_streams_run_in_operational_only,
    test_three_seconds_of_sixteen_signals_are_every_tick_and_the_bits_of_a_capture,
    test_what_can_be_streamed,
)

__all__ = [
    "test_a_command_that_ends_operation_switches_the_power_stage_off",
    "test_a_fault_is_an_event_with_its_tick",
    "test_a_host_that_is_heard_keeps_the_motor_running",
    "test_a_new_host_starts_afresh",
    "test_a_setpoint_is_taken_whole_or_not_at_all",
    "test_a_stopped_drive_says_so",
    "test_a_whole_request_that_makes_no_sense_is_rejected",
    "test_an_object_that_cannot_be_read_is_not_opened_and_a_reset_forgets_an_upload",
    "test_chunks_beyond_the_end_are_refused_with_one_message",
    "test_every_accepted_configuration_is_another_schema_with_counts_of_its_own",
    "test_every_command_is_confirmed_at_once",
    "test_frames_come_together_from_pieces",
    "test_heartbeats_follow_the_drives_time",
    "test_identity_is_that_of_the_dictionary",
    "test_nothing_else_keeps_it_running",
    "test_nothing_that_is_sent_ends_the_server",
    "test_reads_are_answered_by_bytes_or_by_the_reason",
    "test_records_stand_on_the_grid_of_their_stride",
    "test_scaled_records_hold_steps_and_what_does_not_fit_is_marked",
    "test_setpoints_are_taken_in_their_order_and_never_twice",
    "test_setpoints_count_in_operational_only",
    "test_streams_run_in_operational_only",
    "test_three_seconds_of_sixteen_signals_are_every_tick_and_the_bits_of_a_capture",
    "test_what_can_be_streamed",
    "test_what_is_damaged_or_unknown_is_dropped_and_counted",
    "test_writes_are_taken_or_refused_with_the_reason",
]
