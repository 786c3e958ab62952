# SPDX-FileCopyrightText: 2026 The benchtool authors
# SPDX-License-Identifier: MIT
# The headers in C++: part of `make check`.
# make check-cxx         each header alone, and a program that links, with every C++ compiler there is
CXX_COMPILERS = $(foreach cc,g++ clang++,$(if $(shell command -v $(cc)),$(cc)))
CXXFLAGS = -std=c++11 -Wall -Wextra -Werror -pedantic -I. -I.. -DBT_ONE_THREAD
PUBLIC = $(wildcard bt_*.h) benchtool.h ../drive_objects.h

.PHONY: check-cxx

check: check-cxx
check-cxx: $(CXX_COMPILERS:%=$(BUILD)/passed-cxx-%)

$(CXX_COMPILERS:%=$(BUILD)/passed-cxx-%): $(BUILD)/passed-cxx-%: tests/from_cxx.cpp $(CAN_SOURCES) $(SOURCES) $(HEADERS)
	@mkdir -p $(BUILD)/cxx
	@for header in $(PUBLIC); do \
	    printf '#include "%s"\n' $$header | $* $(CXXFLAGS) -fsyntax-only -x c++ - || exit 1; done
	cd $(BUILD)/cxx && $(CC_HERE) -std=c99 -O1 -DBT_ONE_THREAD -I$(CURDIR) -I$(CURDIR)/.. \
	    -c $(addprefix $(CURDIR)/,$(CAN_SOURCES) $(SOURCES))
	$* $(CXXFLAGS) tests/from_cxx.cpp $(patsubst %.c,$(BUILD)/cxx/%.o,$(CAN_SOURCES) $(SOURCES)) -o $(BUILD)/from-$*
	$(BUILD)/from-$*
	@touch $@
