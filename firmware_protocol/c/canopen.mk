# SPDX-FileCopyrightText: 2026 The benchtool authors
# SPDX-License-Identifier: MIT
# The CAN side: part of `make check` and `make size`.
# make drive-canopen     the example on this machine
# make fuzz-canopen      its fuzzer; SECONDS=600 for longer
CAN_SOURCES = bt_canopen_sdo.c bt_canopen_pdo.c bt_canopen.c
CAN_NODE = $(filter-out bt_cobs.c bt_frame.c bt_upload.c bt_server.c benchtool.c,$(SOURCES))
CAN_TESTS = tests/check_canopen.c

.PHONY: drive-canopen library-canopen fuzz-canopen size-canopen

check: $(foreach cc,$(COMPILERS),$(BUILD)/passed-canopen-$(cc)) drive-canopen \
       $(if $(HAS_CLANG),$(BUILD)/passed-fuzz-canopen)
size: size-canopen

$(BUILD)/passed-canopen-%: $(CAN_SOURCES) $(CAN_NODE) $(HEADERS) $(CAN_TESTS)
	@mkdir -p $(BUILD)
	$* $(CFLAGS) -O2 $(CAN_TESTS) $(CAN_SOURCES) $(CAN_NODE) -o $(BUILD)/check-canopen-$*
	$(BUILD)/check-canopen-$*
	$* $(CFLAGS) $(SANITIZERS) $(CAN_TESTS) $(CAN_SOURCES) $(CAN_NODE) -o $(BUILD)/check-canopen-$*-sanitized
	$(BUILD)/check-canopen-$*-sanitized
	@touch $@

drive-canopen: $(BUILD)/posix_can_drive
library-canopen: $(BUILD)/libbenchtool_can.so

CAN_EXAMPLE = examples/posix_can_drive.c examples/slcan.c examples/terminal.c $(TOY)

$(BUILD)/posix_can_drive: $(CAN_EXAMPLE) $(CAN_SOURCES) $(SOURCES) $(HEADERS)
	@mkdir -p $(BUILD)
	$(CC_HERE) $(CFLAGS) -O2 -g $(EXAMPLE) -DBT_CAN_RX_FRAMES=256u -DBT_CAN_TX_FRAMES=256u -DBT_CAN_PDO_FRAMES=1024u \
	    -Iexamples $(CAN_EXAMPLE) $(CAN_SOURCES) $(SOURCES) -lm -o $@

$(BUILD)/libbenchtool_can.so: tests/shared_can.c tests/shared_can.h $(CAN_SOURCES) $(CAN_NODE) $(HEADERS)
	@mkdir -p $(BUILD)
	$(CC_HERE) $(CFLAGS) -O2 -g -DBT_CAPTURE_WORDS=1000000u -Itests -fPIC -shared \
	    tests/shared_can.c $(CAN_SOURCES) $(CAN_NODE) -o $@

$(BUILD)/fuzz_can: fuzz/fuzz_can.c $(CAN_SOURCES) $(CAN_NODE) $(HEADERS)
	@mkdir -p $(BUILD)
	clang $(CFLAGS) $(SANITIZERS) -fsanitize=fuzzer fuzz/fuzz_can.c $(CAN_SOURCES) $(CAN_NODE) -o $@

$(BUILD)/passed-fuzz-canopen: $(BUILD)/fuzz_can
	$(BUILD)/fuzz_can -max_total_time=$(SECONDS_OF_CHECK) -max_len=2048 -seed=1 -verbosity=0 -print_final_stats=1
	@touch $@

fuzz-canopen: $(BUILD)/fuzz_can
	$(BUILD)/fuzz_can -max_total_time=$(SECONDS) -max_len=2048 -print_final_stats=1

size-canopen: $(CAN_SOURCES) $(HEADERS)
	@command -v $(CROSS)gcc >/dev/null || { echo "no size: $(CROSS)gcc is not installed"; exit 1; }
	@mkdir -p $(BUILD)/m4
	@for source in $(CAN_SOURCES) tests/ram_can.c; do \
	    $(CROSS)gcc $(C99) $(M4) -c $$source -o $(BUILD)/m4/$$(basename $$source .c).o || exit 1; done
	@echo "CAN module  code and constants (bytes)"
	@for source in $(CAN_SOURCES); do $(CROSS)size $(BUILD)/m4/$$(basename $$source .c).o | \
	    awk -v name=$$(basename $$source .c) 'NR == 2 { printf "%-16s %6d\n", name, $$1 }'; done
	@echo "struct bt_can     RAM (bytes), with the rings of bt_canopen.h"
	@$(CROSS)nm -S --size-sort $(BUILD)/m4/ram_can.o | while read at size kind name; do \
	    printf "%-16s %6d\n" $${name#ram_} $$((0x$$size)); done
