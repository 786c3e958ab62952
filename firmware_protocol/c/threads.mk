# SPDX-FileCopyrightText: 2026 The benchtool authors
# SPDX-License-Identifier: MIT
# The library under threads, with a mutex as its lock and ThreadSanitizer looking on: part of `make check`.
# make check-threads     with every compiler that can link it
THREADS = -D_XOPEN_SOURCE=700 -include tests/pthread_lock.h -DBT_MAX_REQUEST=1024u -pthread
TSAN = -g -O1 -fsanitize=thread
LINKS_TSAN = printf 'int main(void) { return 0; }\n' | $(1) $(TSAN) -x c - -o /dev/null 2>/dev/null && echo $(1)
TSAN_COMPILERS := $(foreach cc,$(COMPILERS),$(shell $(call LINKS_TSAN,$(cc))))

.PHONY: check-threads tsan-compilers

check: check-threads
check-threads: $(TSAN_COMPILERS:%=$(BUILD)/passed-threads-%)
	@$(foreach cc,$(filter-out $(TSAN_COMPILERS),$(COMPILERS)),echo "not checked for races: $(cc) has no ThreadSanitizer";)

# Names them, for a test that has to know whether there are any.
tsan-compilers:
	@echo "with ThreadSanitizer: $(TSAN_COMPILERS)"

$(TSAN_COMPILERS:%=$(BUILD)/passed-threads-%): $(BUILD)/passed-threads-%: tests/threads.c tests/pthread_lock.h $(CAN_SOURCES) $(SOURCES) $(HEADERS)
	@mkdir -p $(BUILD)
	$* $(C99) $(THREADS) $(TSAN) -Itests tests/threads.c $(CAN_SOURCES) $(SOURCES) -o $(BUILD)/threads-$*
	TSAN_OPTIONS=halt_on_error=1:exitcode=66 $(BUILD)/threads-$*
	@touch $@
