/* The parts of the test program. */
#ifndef CHECK_H
#define CHECK_H

#include "benchtool.h"

/* A drive just powered up, at 1 kHz, that has said so. */
void check_power_up(struct bt_drive *drive);

void check_vectors(void);
void check_objects(void);
void check_control(void);
void check_records(void);

#endif
