/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
#include "bt_relations.h"

#include "bt_bytes.h"

/* `lower` is at most `times` the value of `upper`, or, in `minima`, `upper` at least `times` that of `lower`. All are
 * F32: the generator of drive_objects.h sees to it. */
struct relation {
    uint16_t lower, upper; /* enum bt_id; BT_ID_NONE after the last one */
    float times;
};
#define LAST { BT_ID_NONE, BT_ID_NONE, 0.0f }

#define AT_MOST(name, most, times) { BT_ID_##name, BT_ID_##most, (times) },
static const struct relation maxima[] = { BT_MAX_ENTRIES(AT_MOST) LAST };

#define AT_LEAST(name, least, times) { BT_ID_##least, BT_ID_##name, (times) },
static const struct relation minima[] = { BT_MIN_ENTRIES(AT_LEAST) LAST };

static float value_of(const struct bt_variables *variables, const uint32_t *parameters, uint16_t id)
{
    uint32_t before, place = 0;
    if (parameters == NULL || bt_entries[id].role != BT_ROLE_PARAMETER)
        return bt_load(variables, (enum bt_id)id).f;
    for (before = 0; before < id; before++)
        place += bt_entries[before].role == BT_ROLE_PARAMETER;
    return bt_float_of(parameters[place]);
}

static bool is_above(float lower, float upper, float times)
{
    return upper > 0.0f && lower > upper * times;
}

uint32_t bt_check_relations(const struct bt_variables *variables, const uint32_t *parameters, enum bt_id id,
                            union bt_number number)
{
    const struct relation *each;
    for (each = maxima; each->lower != BT_ID_NONE; each++) {
        if (each->lower == id && is_above(number.f, value_of(variables, parameters, each->upper), each->times))
            return BT_ABORT_VALUE_HIGH;
    }
    for (each = minima; each->lower != BT_ID_NONE; each++) {
        if (each->upper == id && number.f < value_of(variables, parameters, each->lower) * each->times)
            return BT_ABORT_VALUE_LOW;
    }
    for (each = maxima; each->lower != BT_ID_NONE; each++) {
        if (each->upper == id && is_above(value_of(variables, parameters, each->lower), number.f, each->times))
            return BT_ABORT_PARAMETER_INCOMPATIBLE;
    }
    return BT_OK;
}

static void raise_to_minima(struct bt_variables *variables)
{
    const struct relation *each;
    for (each = minima; each->lower != BT_ID_NONE; each++) {
        union bt_number least;
        least.f = value_of(variables, NULL, each->lower) * each->times;
        if (value_of(variables, NULL, each->upper) < least.f)
            bt_store(variables, (enum bt_id)each->upper, least);
    }
}

/* Once more after every cut: what was cut may limit another. */
void bt_cut_to_relations(struct bt_variables *variables)
{
    const struct relation *each = maxima;
    raise_to_minima(variables);
    while (each->lower != BT_ID_NONE) {
        const float upper = value_of(variables, NULL, each->upper);
        if (is_above(value_of(variables, NULL, each->lower), upper, each->times)) {
            union bt_number most;
            most.f = upper * each->times;
            bt_store(variables, (enum bt_id)each->lower, most);
            each = maxima;
        } else {
            each++;
        }
    }
}
