/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Process data on the bus (CiA 301, 7.2.2): TPDOs by their event timer, sampled in the control interrupt, and RPDOs.
 * Their mapping is in the objects 0x1400 to 0x1BFF, whose rules are those of bt_pdo.h. */
#ifndef BT_CANOPEN_PDO_H
#define BT_CANOPEN_PDO_H

#include "bt_node.h"

#ifdef __cplusplus
extern "C" {
#endif

#define BT_TPDOS 8u
#define BT_RPDOS 2u
#define BT_PDO_ENTRIES 4u

struct bt_can_frame {
    uint16_t id; /* 11 bits */
    uint8_t n;
    uint8_t data[8];
};

/* The variables of the objects 0x1800 to 0x1BFF, which are neighbours. */
#define BT_TPDO_FIRST offsetof(struct bt_variables, tpdo1_count)
#define BT_TPDO_BYTES (offsetof(struct bt_variables, tpdo8_mapping_4) + sizeof(uint32_t) - BT_TPDO_FIRST)

struct bt_tpdo {
    uint32_t ticks; /* between two of them */
    uint32_t due;   /* the tick of the next one, a multiple of these since power-up; of the control interrupt */
    uint16_t can_id;
    bool is_first; /* TPDO1, which counts them */
    uint8_t count;
    uint16_t ids[BT_PDO_ENTRIES];
};

/* TPDOs in use, lowest identifier first. The main loop makes the next set while the control interrupt goes by the
 * active one, and hands over by writing `active` with the lock held: from then on the other set is its own. */
struct bt_tpdos {
    volatile uint8_t active;
    struct {
        uint8_t count;
        struct bt_tpdo pdos[BT_TPDOS];
    } sets[2];
    uint8_t seen[BT_TPDO_BYTES]; /* the objects of the active set */
};

/* Main loop: goes by what the objects say now. */
void bt_tpdos_renew(struct bt_tpdos *tpdos, const struct bt_device *device);

/* Control interrupt, in every tick: the frames that are due in it, none unless `operational`; how many. `frames` takes
 * BT_TPDOS of them. */
size_t bt_tpdos_tick(struct bt_tpdos *tpdos, struct bt_device *device, bool operational, struct bt_can_frame *frames);

/* Takes setpoints as a whole or not at all; identifiers of no RPDO are not ours. The control interrupt sees
 * torque_command and omega_m_command change together if they are mapped in this order, and nothing else; entries of
 * other mappings change one after the other. */
void bt_rpdo_take(struct bt_node *node, uint16_t can_id, const uint8_t *data, size_t n);

#ifdef __cplusplus
}
#endif

#endif
