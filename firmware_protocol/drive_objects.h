/* SPDX-FileCopyrightText: 2026 The benchtool authors
 * SPDX-License-Identifier: MIT */
/* Generated from objects.toml by python -m firmware_protocol.generate; do not edit. */
#ifndef BENCHTOOL_DRIVE_OBJECTS_H
#define BENCHTOOL_DRIVE_OBJECTS_H

#ifdef __cplusplus
extern "C" {
#endif

#define BT_DICTIONARY_HASH 0x49A8518Eu
#define BT_VENDOR_ID 0x00000B7Cu
#define BT_PRODUCT_CODE 0x00002011u
#define BT_REVISION 0x00010001u

/* CiA 301 data types */
enum bt_type {
    BT_TYPE_I8 = 2,
    BT_TYPE_U8 = 5,
    BT_TYPE_I16 = 3,
    BT_TYPE_U16 = 6,
    BT_TYPE_I32 = 4,
    BT_TYPE_U32 = 7,
    BT_TYPE_I64 = 21,
    BT_TYPE_U64 = 27,
    BT_TYPE_F32 = 8,
    BT_TYPE_F64 = 17,
    BT_TYPE_STRING = 9,
    BT_TYPE_DOMAIN = 15
};

/* Bytes of a value; 0 where they are not the same for all of the type */
#define BT_SIZE_I8 1u
#define BT_SIZE_U8 1u
#define BT_SIZE_I16 2u
#define BT_SIZE_U16 2u
#define BT_SIZE_I32 4u
#define BT_SIZE_U32 4u
#define BT_SIZE_I64 8u
#define BT_SIZE_U64 8u
#define BT_SIZE_F32 4u
#define BT_SIZE_F64 8u
#define BT_SIZE_STRING 0u
#define BT_SIZE_DOMAIN 0u

enum bt_access {
    BT_ACCESS_RO = 0,
    BT_ACCESS_RW = 1,
    BT_ACCESS_WO = 2,
    BT_ACCESS_CONST = 3
};

enum bt_role {
    BT_ROLE_PARAMETER = 0,
    BT_ROLE_COMMAND = 1,
    BT_ROLE_SIGNAL = 2,
    BT_ROLE_STATUS = 3
};

/* Indices of the objects */
#define BT_INDEX_DEVICE_TYPE 0x1000u
#define BT_INDEX_ERROR_REGISTER 0x1001u
#define BT_INDEX_ERROR_HISTORY 0x1003u
#define BT_INDEX_SYNC_COB_ID 0x1005u
#define BT_INDEX_DEVICE_NAME 0x1008u
#define BT_INDEX_HARDWARE_VERSION 0x1009u
#define BT_INDEX_FIRMWARE_VERSION 0x100Au
#define BT_INDEX_STORE_PARAMETERS 0x1010u
#define BT_INDEX_RESTORE_DEFAULT_PARAMETERS 0x1011u
#define BT_INDEX_EMCY_COB_ID 0x1014u
#define BT_INDEX_CONSUMER_HEARTBEAT 0x1016u
#define BT_INDEX_PRODUCER_HEARTBEAT 0x1017u
#define BT_INDEX_IDENTITY 0x1018u
#define BT_INDEX_SDO_SERVER_PARAMETER 0x1200u
#define BT_INDEX_RPDO1 0x1400u
#define BT_INDEX_RPDO2 0x1401u
#define BT_INDEX_RPDO1_MAPPING 0x1600u
#define BT_INDEX_RPDO2_MAPPING 0x1601u
#define BT_INDEX_TPDO1 0x1800u
#define BT_INDEX_TPDO2 0x1801u
#define BT_INDEX_TPDO3 0x1802u
#define BT_INDEX_TPDO4 0x1803u
#define BT_INDEX_TPDO5 0x1804u
#define BT_INDEX_TPDO6 0x1805u
#define BT_INDEX_TPDO7 0x1806u
#define BT_INDEX_TPDO8 0x1807u
#define BT_INDEX_TPDO1_MAPPING 0x1A00u
#define BT_INDEX_TPDO2_MAPPING 0x1A01u
#define BT_INDEX_TPDO3_MAPPING 0x1A02u
#define BT_INDEX_TPDO4_MAPPING 0x1A03u
#define BT_INDEX_TPDO5_MAPPING 0x1A04u
#define BT_INDEX_TPDO6_MAPPING 0x1A05u
#define BT_INDEX_TPDO7_MAPPING 0x1A06u
#define BT_INDEX_TPDO8_MAPPING 0x1A07u
#define BT_INDEX_MOTOR 0x2000u
#define BT_INDEX_SENSORS 0x2001u
#define BT_INDEX_TORQUE_CONTROL 0x2010u
#define BT_INDEX_SPEED_CONTROL 0x2011u
#define BT_INDEX_PROTECTION 0x2012u
#define BT_INDEX_SVM_DTC_CONTROL 0x2013u
#define BT_INDEX_DTC_CONTROL 0x2014u
#define BT_INDEX_FCS_MPC_CONTROL 0x2015u
#define BT_INDEX_FOC_CONTROL 0x2016u
#define BT_INDEX_CURRENT_OFFSETS 0x2017u
#define BT_INDEX_COMMAND 0x2020u
#define BT_INDEX_STIMULUS_TABLE 0x2021u
#define BT_INDEX_SIGNALS 0x2030u
#define BT_INDEX_CAPTURE 0x2040u
#define BT_INDEX_CAPTURE_CHANNELS 0x2041u
#define BT_INDEX_CAPTURE_DATA 0x2042u
#define BT_INDEX_LINK 0x2050u
#define BT_INDEX_PROCESS_DATA 0x2051u
#define BT_INDEX_DICTIONARY_HASH 0x2060u
#define BT_INDEX_ABORT_CONNECTION_OPTION 0x6007u
#define BT_INDEX_ERROR_CODE 0x603Fu
#define BT_INDEX_CONTROLWORD 0x6040u
#define BT_INDEX_STATUSWORD 0x6041u
#define BT_INDEX_QUICK_STOP_OPTION 0x605Au
#define BT_INDEX_HALT_OPTION 0x605Du
#define BT_INDEX_FAULT_REACTION_OPTION 0x605Eu
#define BT_INDEX_MODE_OF_OPERATION 0x6060u
#define BT_INDEX_MODE_OF_OPERATION_DISPLAY 0x6061u
#define BT_INDEX_VELOCITY_ACTUAL 0x606Cu
#define BT_INDEX_TARGET_TORQUE 0x6071u
#define BT_INDEX_MAX_TORQUE 0x6072u
#define BT_INDEX_MOTOR_RATED_CURRENT 0x6075u
#define BT_INDEX_MOTOR_RATED_TORQUE 0x6076u
#define BT_INDEX_TORQUE_ACTUAL 0x6077u
#define BT_INDEX_CURRENT_ACTUAL 0x6078u
#define BT_INDEX_DC_LINK_VOLTAGE 0x6079u
#define BT_INDEX_TARGET_VELOCITY 0x60FFu
#define BT_INDEX_SUPPORTED_MODES 0x6502u

/* Sub-indices of the entries */
#define BT_SUB_DEVICE_TYPE 0u
#define BT_SUB_ERROR_REGISTER 0u
#define BT_SUB_ERROR_HISTORY_COUNT 0u
#define BT_SUB_ERROR_1 1u
#define BT_SUB_ERROR_2 2u
#define BT_SUB_ERROR_3 3u
#define BT_SUB_ERROR_4 4u
#define BT_SUB_ERROR_5 5u
#define BT_SUB_ERROR_6 6u
#define BT_SUB_ERROR_7 7u
#define BT_SUB_ERROR_8 8u
#define BT_SUB_SYNC_COB_ID 0u
#define BT_SUB_DEVICE_NAME 0u
#define BT_SUB_HARDWARE_VERSION 0u
#define BT_SUB_FIRMWARE_VERSION 0u
#define BT_SUB_STORE_PARAMETERS_COUNT 0u
#define BT_SUB_STORE_ALL 1u
#define BT_SUB_RESTORE_DEFAULT_PARAMETERS_COUNT 0u
#define BT_SUB_RESTORE_ALL 1u
#define BT_SUB_EMCY_COB_ID 0u
#define BT_SUB_CONSUMER_HEARTBEAT_COUNT 0u
#define BT_SUB_HOST_HEARTBEAT 1u
#define BT_SUB_PRODUCER_HEARTBEAT 0u
#define BT_SUB_IDENTITY_COUNT 0u
#define BT_SUB_VENDOR_ID 1u
#define BT_SUB_PRODUCT_CODE 2u
#define BT_SUB_REVISION_NUMBER 3u
#define BT_SUB_SERIAL_NUMBER 4u
#define BT_SUB_SDO_SERVER_PARAMETER_COUNT 0u
#define BT_SUB_SDO_REQUEST_COB_ID 1u
#define BT_SUB_SDO_RESPONSE_COB_ID 2u
#define BT_SUB_RPDO1_COUNT 0u
#define BT_SUB_RPDO1_COB_ID 1u
#define BT_SUB_RPDO1_TRANSMISSION_TYPE 2u
#define BT_SUB_RPDO2_COUNT 0u
#define BT_SUB_RPDO2_COB_ID 1u
#define BT_SUB_RPDO2_TRANSMISSION_TYPE 2u
#define BT_SUB_RPDO1_MAPPING_COUNT 0u
#define BT_SUB_RPDO1_MAPPING_1 1u
#define BT_SUB_RPDO1_MAPPING_2 2u
#define BT_SUB_RPDO1_MAPPING_3 3u
#define BT_SUB_RPDO1_MAPPING_4 4u
#define BT_SUB_RPDO2_MAPPING_COUNT 0u
#define BT_SUB_RPDO2_MAPPING_1 1u
#define BT_SUB_RPDO2_MAPPING_2 2u
#define BT_SUB_RPDO2_MAPPING_3 3u
#define BT_SUB_RPDO2_MAPPING_4 4u
#define BT_SUB_TPDO1_COUNT 0u
#define BT_SUB_TPDO1_COB_ID 1u
#define BT_SUB_TPDO1_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO1_EVENT_TIMER 5u
#define BT_SUB_TPDO2_COUNT 0u
#define BT_SUB_TPDO2_COB_ID 1u
#define BT_SUB_TPDO2_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO2_EVENT_TIMER 5u
#define BT_SUB_TPDO3_COUNT 0u
#define BT_SUB_TPDO3_COB_ID 1u
#define BT_SUB_TPDO3_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO3_EVENT_TIMER 5u
#define BT_SUB_TPDO4_COUNT 0u
#define BT_SUB_TPDO4_COB_ID 1u
#define BT_SUB_TPDO4_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO4_EVENT_TIMER 5u
#define BT_SUB_TPDO5_COUNT 0u
#define BT_SUB_TPDO5_COB_ID 1u
#define BT_SUB_TPDO5_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO5_EVENT_TIMER 5u
#define BT_SUB_TPDO6_COUNT 0u
#define BT_SUB_TPDO6_COB_ID 1u
#define BT_SUB_TPDO6_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO6_EVENT_TIMER 5u
#define BT_SUB_TPDO7_COUNT 0u
#define BT_SUB_TPDO7_COB_ID 1u
#define BT_SUB_TPDO7_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO7_EVENT_TIMER 5u
#define BT_SUB_TPDO8_COUNT 0u
#define BT_SUB_TPDO8_COB_ID 1u
#define BT_SUB_TPDO8_TRANSMISSION_TYPE 2u
#define BT_SUB_TPDO8_EVENT_TIMER 5u
#define BT_SUB_TPDO1_MAPPING_COUNT 0u
#define BT_SUB_TPDO1_MAPPING_1 1u
#define BT_SUB_TPDO1_MAPPING_2 2u
#define BT_SUB_TPDO1_MAPPING_3 3u
#define BT_SUB_TPDO1_MAPPING_4 4u
#define BT_SUB_TPDO2_MAPPING_COUNT 0u
#define BT_SUB_TPDO2_MAPPING_1 1u
#define BT_SUB_TPDO2_MAPPING_2 2u
#define BT_SUB_TPDO2_MAPPING_3 3u
#define BT_SUB_TPDO2_MAPPING_4 4u
#define BT_SUB_TPDO3_MAPPING_COUNT 0u
#define BT_SUB_TPDO3_MAPPING_1 1u
#define BT_SUB_TPDO3_MAPPING_2 2u
#define BT_SUB_TPDO3_MAPPING_3 3u
#define BT_SUB_TPDO3_MAPPING_4 4u
#define BT_SUB_TPDO4_MAPPING_COUNT 0u
#define BT_SUB_TPDO4_MAPPING_1 1u
#define BT_SUB_TPDO4_MAPPING_2 2u
#define BT_SUB_TPDO4_MAPPING_3 3u
#define BT_SUB_TPDO4_MAPPING_4 4u
#define BT_SUB_TPDO5_MAPPING_COUNT 0u
#define BT_SUB_TPDO5_MAPPING_1 1u
#define BT_SUB_TPDO5_MAPPING_2 2u
#define BT_SUB_TPDO5_MAPPING_3 3u
#define BT_SUB_TPDO5_MAPPING_4 4u
#define BT_SUB_TPDO6_MAPPING_COUNT 0u
#define BT_SUB_TPDO6_MAPPING_1 1u
#define BT_SUB_TPDO6_MAPPING_2 2u
#define BT_SUB_TPDO6_MAPPING_3 3u
#define BT_SUB_TPDO6_MAPPING_4 4u
#define BT_SUB_TPDO7_MAPPING_COUNT 0u
#define BT_SUB_TPDO7_MAPPING_1 1u
#define BT_SUB_TPDO7_MAPPING_2 2u
#define BT_SUB_TPDO7_MAPPING_3 3u
#define BT_SUB_TPDO7_MAPPING_4 4u
#define BT_SUB_TPDO8_MAPPING_COUNT 0u
#define BT_SUB_TPDO8_MAPPING_1 1u
#define BT_SUB_TPDO8_MAPPING_2 2u
#define BT_SUB_TPDO8_MAPPING_3 3u
#define BT_SUB_TPDO8_MAPPING_4 4u
#define BT_SUB_MOTOR_COUNT 0u
#define BT_SUB_POLE_PAIRS 1u
#define BT_SUB_R_S 2u
#define BT_SUB_L_D 3u
#define BT_SUB_L_Q 4u
#define BT_SUB_PSI_R 5u
#define BT_SUB_J 6u
#define BT_SUB_T_N 7u
#define BT_SUB_OMEGA_M_N 8u
#define BT_SUB_SENSORS_COUNT 0u
#define BT_SUB_ENCODER_LINES 1u
#define BT_SUB_ENCODER_OFFSET 2u
#define BT_SUB_I_FULL_SCALE 3u
#define BT_SUB_CONTROL_PERIOD 4u
#define BT_SUB_U_DC_FULL_SCALE 5u
#define BT_SUB_PWM_PERIOD 6u
#define BT_SUB_ENCODER_DIRECTION 7u
#define BT_SUB_PHASE_ORDER 8u
#define BT_SUB_CURRENT_OFFSET_A 9u
#define BT_SUB_CURRENT_OFFSET_B 10u
#define BT_SUB_CURRENT_OFFSET_C 11u
#define BT_SUB_CURRENT_GAIN_A 12u
#define BT_SUB_CURRENT_GAIN_B 13u
#define BT_SUB_CURRENT_GAIN_C 14u
#define BT_SUB_ENCODER_REFERENCE 15u
#define BT_SUB_ANGLE_KNOWN 16u
#define BT_SUB_TORQUE_CONTROL_COUNT 0u
#define BT_SUB_LAW 1u
#define BT_SUB_U_S 2u
#define BT_SUB_T_K_RATIO 3u
#define BT_SUB_DELAY_COMPENSATION 4u
#define BT_SUB_DEAD_TIME_COMPENSATION 5u
#define BT_SUB_FLUX_COMPARATOR 6u
#define BT_SUB_LAMBDA_REFERENCE 7u
#define BT_SUB_SPEED_CONTROL_COUNT 0u
#define BT_SUB_K_P_SPEED 1u
#define BT_SUB_K_I_SPEED 2u
#define BT_SUB_TORQUE_LIMIT 3u
#define BT_SUB_OMEGA_OBSERVER 4u
#define BT_SUB_PROTECTION_COUNT 0u
#define BT_SUB_I_TRIP 1u
#define BT_SUB_OMEGA_M_TRIP 2u
#define BT_SUB_U_DC_MIN 3u
#define BT_SUB_U_DC_MAX 4u
#define BT_SUB_I2T_CURRENT 5u
#define BT_SUB_I2T_TAU 6u
#define BT_SUB_I2T_LEVEL 7u
#define BT_SUB_WINDING_TEMPERATURE 8u
#define BT_SUB_TEMPERATURE_TRIP 9u
#define BT_SUB_SVM_DTC_CONTROL_COUNT 0u
#define BT_SUB_K_P_DELTA 1u
#define BT_SUB_K_I_DELTA 2u
#define BT_SUB_DTC_CONTROL_COUNT 0u
#define BT_SUB_TORQUE_BAND 1u
#define BT_SUB_FLUX_BAND 2u
#define BT_SUB_FCS_MPC_CONTROL_COUNT 0u
#define BT_SUB_FLUX_WEIGHT 1u
#define BT_SUB_FOC_CONTROL_COUNT 0u
#define BT_SUB_OMEGA_CURRENT 1u
#define BT_SUB_CURRENT_OFFSETS_COUNT 0u
#define BT_SUB_OFFSET_CALIBRATION 1u
#define BT_SUB_OFFSET_CALIBRATION_STATE 2u
#define BT_SUB_OFFSET_CALIBRATION_TICKS 3u
#define BT_SUB_COMMAND_COUNT 0u
#define BT_SUB_TORQUE_COMMAND 1u
#define BT_SUB_OMEGA_M_COMMAND 2u
#define BT_SUB_PSI_S_COMMAND 3u
#define BT_SUB_STIMULUS_TABLE_COUNT 0u
#define BT_SUB_STIMULUS_CONTROL 1u
#define BT_SUB_STIMULUS_STATE 2u
#define BT_SUB_STIMULUS_QUANTITY 3u
#define BT_SUB_STIMULUS_SHAPE 4u
#define BT_SUB_STIMULUS_AMPLITUDE 5u
#define BT_SUB_STIMULUS_OFFSET 6u
#define BT_SUB_STIMULUS_TICKS 7u
#define BT_SUB_STIMULUS_REPETITIONS 8u
#define BT_SUB_STIMULUS_FREQUENCY_START 9u
#define BT_SUB_STIMULUS_FREQUENCY_END 10u
#define BT_SUB_STIMULUS_STEPS 11u
#define BT_SUB_STIMULUS_PRBS_CLOCK 12u
#define BT_SUB_STIMULUS_PRBS_LENGTH 13u
#define BT_SUB_STIMULUS_SEED 14u
#define BT_SUB_STIMULUS_FRAME 15u
#define BT_SUB_STIMULUS_ANGLE 16u
#define BT_SUB_STIMULUS_START_TICK 17u
#define BT_SUB_STIMULUS_OMEGA_E 18u
#define BT_SUB_STIMULUS_TURN_TICKS 19u
#define BT_SUB_SIGNALS_COUNT 0u
#define BT_SUB_TICK 1u
#define BT_SUB_I_A 2u
#define BT_SUB_I_B 3u
#define BT_SUB_I_C 4u
#define BT_SUB_I_D 5u
#define BT_SUB_I_Q 6u
#define BT_SUB_U_ALPHA 7u
#define BT_SUB_U_BETA 8u
#define BT_SUB_U_DC 9u
#define BT_SUB_THETA_M 10u
#define BT_SUB_OMEGA_M 11u
#define BT_SUB_TORQUE 12u
#define BT_SUB_TORQUE_REFERENCE 13u
#define BT_SUB_PSI_S 14u
#define BT_SUB_PSI_S_REFERENCE 15u
#define BT_SUB_LAW_ANGLE 16u
#define BT_SUB_LAW_CLIPPED 17u
#define BT_SUB_SWITCHING_COUNT 18u
#define BT_SUB_ADC_SATURATED 19u
#define BT_SUB_PSI_ALPHA 20u
#define BT_SUB_PSI_BETA 21u
#define BT_SUB_STIMULUS 22u
#define BT_SUB_CAPTURE_COUNT 0u
#define BT_SUB_CAPTURE_CONTROL 1u
#define BT_SUB_CAPTURE_STATE 2u
#define BT_SUB_CAPTURE_ROWS 3u
#define BT_SUB_CAPTURE_STRIDE 4u
#define BT_SUB_CAPTURE_PRETRIGGER 5u
#define BT_SUB_CAPTURE_TRIGGER 6u
#define BT_SUB_CAPTURE_TRIGGER_SIGNAL 7u
#define BT_SUB_CAPTURE_TRIGGER_LEVEL 8u
#define BT_SUB_CAPTURE_TRIGGER_TICK 9u
#define BT_SUB_CAPTURE_ROWS_DONE 10u
#define BT_SUB_CAPTURE_SEQUENCE 11u
#define BT_SUB_CAPTURE_CHANNELS_COUNT 0u
#define BT_SUB_CAPTURE_CHANNEL_1 1u
#define BT_SUB_CAPTURE_CHANNEL_2 2u
#define BT_SUB_CAPTURE_CHANNEL_3 3u
#define BT_SUB_CAPTURE_CHANNEL_4 4u
#define BT_SUB_CAPTURE_CHANNEL_5 5u
#define BT_SUB_CAPTURE_CHANNEL_6 6u
#define BT_SUB_CAPTURE_CHANNEL_7 7u
#define BT_SUB_CAPTURE_CHANNEL_8 8u
#define BT_SUB_CAPTURE_CHANNEL_9 9u
#define BT_SUB_CAPTURE_CHANNEL_10 10u
#define BT_SUB_CAPTURE_CHANNEL_11 11u
#define BT_SUB_CAPTURE_CHANNEL_12 12u
#define BT_SUB_CAPTURE_CHANNEL_13 13u
#define BT_SUB_CAPTURE_CHANNEL_14 14u
#define BT_SUB_CAPTURE_CHANNEL_15 15u
#define BT_SUB_CAPTURE_CHANNEL_16 16u
#define BT_SUB_CAPTURE_DATA 0u
#define BT_SUB_LINK_COUNT 0u
#define BT_SUB_LINK_STATE 1u
#define BT_SUB_LINK_LOSSES 2u
#define BT_SUB_PARAMETER_TRIAL 3u
#define BT_SUB_PROCESS_DATA_COUNT 0u
#define BT_SUB_STREAM_SEQUENCE 1u
#define BT_SUB_RPDO_DROPPED 2u
#define BT_SUB_SERIAL_DROPPED 3u
#define BT_SUB_DICTIONARY_HASH 0u
#define BT_SUB_ABORT_CONNECTION_OPTION 0u
#define BT_SUB_ERROR_CODE 0u
#define BT_SUB_CONTROLWORD 0u
#define BT_SUB_STATUSWORD 0u
#define BT_SUB_QUICK_STOP_OPTION 0u
#define BT_SUB_HALT_OPTION 0u
#define BT_SUB_FAULT_REACTION_OPTION 0u
#define BT_SUB_MODE_OF_OPERATION 0u
#define BT_SUB_MODE_OF_OPERATION_DISPLAY 0u
#define BT_SUB_VELOCITY_ACTUAL 0u
#define BT_SUB_TARGET_TORQUE 0u
#define BT_SUB_MAX_TORQUE 0u
#define BT_SUB_MOTOR_RATED_CURRENT 0u
#define BT_SUB_MOTOR_RATED_TORQUE 0u
#define BT_SUB_TORQUE_ACTUAL 0u
#define BT_SUB_CURRENT_ACTUAL 0u
#define BT_SUB_DC_LINK_VOLTAGE 0u
#define BT_SUB_TARGET_VELOCITY 0u
#define BT_SUB_SUPPORTED_MODES 0u

/* Enumerations */
enum bt_encoder_direction {
    BT_ENCODER_DIRECTION_FORWARD = 1,
    BT_ENCODER_DIRECTION_REVERSE = -1
};

enum bt_phase_order {
    BT_PHASE_ORDER_ABC = 0,
    BT_PHASE_ORDER_ACB = 1
};

enum bt_encoder_reference {
    BT_ENCODER_REFERENCE_ABSOLUTE = 0,
    BT_ENCODER_REFERENCE_INDEX = 1
};

enum bt_angle_known {
    BT_ANGLE_KNOWN_NO = 0,
    BT_ANGLE_KNOWN_YES = 1
};

enum bt_law {
    BT_LAW_TPC = 0,
    BT_LAW_TPC_STATOR = 1,
    BT_LAW_SVM_DTC = 2,
    BT_LAW_DTC = 3,
    BT_LAW_FCS_MPC = 4,
    BT_LAW_FOC = 5,
    BT_LAW_DEADBEAT = 6
};

enum bt_delay_compensation {
    BT_DELAY_COMPENSATION_OFF = 0,
    BT_DELAY_COMPENSATION_ON = 1
};

enum bt_flux_comparator {
    BT_FLUX_COMPARATOR_PLAIN = 0,
    BT_FLUX_COMPARATOR_ACCUMULATED = 1
};

enum bt_lambda_reference {
    BT_LAMBDA_REFERENCE_START = 0,
    BT_LAMBDA_REFERENCE_END = 1
};

enum bt_offset_calibration {
    BT_OFFSET_CALIBRATION_STOP = 0,
    BT_OFFSET_CALIBRATION_START = 1
};

enum bt_offset_calibration_state {
    BT_OFFSET_CALIBRATION_STATE_IDLE = 0,
    BT_OFFSET_CALIBRATION_STATE_RUNNING = 1,
    BT_OFFSET_CALIBRATION_STATE_DONE = 2,
    BT_OFFSET_CALIBRATION_STATE_FAILED = 3
};

enum bt_stimulus_control {
    BT_STIMULUS_CONTROL_STOP = 0,
    BT_STIMULUS_CONTROL_START = 1
};

enum bt_stimulus_state {
    BT_STIMULUS_STATE_IDLE = 0,
    BT_STIMULUS_STATE_RUNNING = 1,
    BT_STIMULUS_STATE_DONE = 2
};

enum bt_stimulus_quantity {
    BT_STIMULUS_QUANTITY_TORQUE = 0,
    BT_STIMULUS_QUANTITY_SPEED = 1,
    BT_STIMULUS_QUANTITY_D_CURRENT = 2,
    BT_STIMULUS_QUANTITY_VOLTAGE = 3,
    BT_STIMULUS_QUANTITY_CURRENT = 4
};

enum bt_stimulus_shape {
    BT_STIMULUS_SHAPE_CONSTANT = 0,
    BT_STIMULUS_SHAPE_STEP = 1,
    BT_STIMULUS_SHAPE_STAIRCASE = 2,
    BT_STIMULUS_SHAPE_RAMP = 3,
    BT_STIMULUS_SHAPE_SINE = 4,
    BT_STIMULUS_SHAPE_CHIRP_LINEAR = 5,
    BT_STIMULUS_SHAPE_CHIRP_LOGARITHMIC = 6,
    BT_STIMULUS_SHAPE_PRBS = 7
};

enum bt_stimulus_frame {
    BT_STIMULUS_FRAME_STATOR = 0,
    BT_STIMULUS_FRAME_ROTOR = 1
};

enum bt_capture_control {
    BT_CAPTURE_CONTROL_ABORT = 0,
    BT_CAPTURE_CONTROL_ARM = 1
};

enum bt_capture_state {
    BT_CAPTURE_STATE_IDLE = 0,
    BT_CAPTURE_STATE_ARMED = 1,
    BT_CAPTURE_STATE_TRIGGERED = 2,
    BT_CAPTURE_STATE_COMPLETE = 3,
    BT_CAPTURE_STATE_ABORTED = 4
};

enum bt_capture_trigger {
    BT_CAPTURE_TRIGGER_IMMEDIATE = 0,
    BT_CAPTURE_TRIGGER_SETPOINT = 1,
    BT_CAPTURE_TRIGGER_RISING = 2,
    BT_CAPTURE_TRIGGER_FALLING = 3,
    BT_CAPTURE_TRIGGER_FAULT = 4,
    BT_CAPTURE_TRIGGER_STIMULUS = 5
};

enum bt_link_state {
    BT_LINK_STATE_OFF = 0,
    BT_LINK_STATE_WAITING = 1,
    BT_LINK_STATE_ALIVE = 2,
    BT_LINK_STATE_LOST = 3
};

enum bt_parameter_trial {
    BT_PARAMETER_TRIAL_OFF = 0,
    BT_PARAMETER_TRIAL_ON = 1
};

enum bt_abort_connection_option {
    BT_ABORT_CONNECTION_OPTION_FAULT = 1,
    BT_ABORT_CONNECTION_OPTION_DISABLE_VOLTAGE = 2,
    BT_ABORT_CONNECTION_OPTION_QUICK_STOP = 3
};

enum bt_quick_stop_option {
    BT_QUICK_STOP_OPTION_DISABLE = 0,
    BT_QUICK_STOP_OPTION_RAMP = 2,
    BT_QUICK_STOP_OPTION_SLOW_DOWN_AND_HOLD = 5,
    BT_QUICK_STOP_OPTION_RAMP_AND_HOLD = 6
};

enum bt_halt_option {
    BT_HALT_OPTION_TORQUE_LIMIT = 3
};

enum bt_fault_reaction_option {
    BT_FAULT_REACTION_OPTION_DISABLE = 0
};

enum bt_mode_of_operation {
    BT_MODE_OF_OPERATION_CURRENT = -2,
    BT_MODE_OF_OPERATION_VOLTAGE = -1,
    BT_MODE_OF_OPERATION_VELOCITY = 3,
    BT_MODE_OF_OPERATION_TORQUE = 4
};

enum bt_mode_of_operation_display {
    BT_MODE_OF_OPERATION_DISPLAY_CURRENT = -2,
    BT_MODE_OF_OPERATION_DISPLAY_VOLTAGE = -1,
    BT_MODE_OF_OPERATION_DISPLAY_VELOCITY = 3,
    BT_MODE_OF_OPERATION_DISPLAY_TORQUE = 4
};

/* Every entry as
 *   X(index, sub, name, TYPE, ACCESS, ROLE, enabled_write, add_node_id, minimum, maximum, initial)
 * with raw values; where the table has no limit, that of the type. A string's or domain's limits are 0.
 * name is a C identifier; TYPE, ACCESS and ROLE go behind BT_TYPE_, BT_ACCESS_ and BT_ROLE_, TYPE also behind
 * BT_SIZE_. Where a value is kept is not said here. */
#define BT_ENTRIES(X) \
    X(0x1000u, 0u, device_type, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 131474u) \
    X(0x1001u, 0u, error_register, U8, RO, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1003u, 0u, error_history_count, U8, RW, STATUS, 1, 0, 0u, 255u, 8u) \
    X(0x1003u, 1u, error_1, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 2u, error_2, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 3u, error_3, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 4u, error_4, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 5u, error_5, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 6u, error_6, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 7u, error_7, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1003u, 8u, error_8, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1005u, 0u, sync_cob_id, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 128u) \
    X(0x1008u, 0u, device_name, STRING, CONST, STATUS, 1, 0, 0, 0, "benchtool reference drive") \
    X(0x1009u, 0u, hardware_version, STRING, CONST, STATUS, 1, 0, 0, 0, "emulated") \
    X(0x100Au, 0u, firmware_version, STRING, CONST, STATUS, 1, 0, 0, 0, "0.1.0") \
    X(0x1010u, 0u, store_parameters_count, U8, RO, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x1010u, 1u, store_all, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 1u) \
    X(0x1011u, 0u, restore_default_parameters_count, U8, RO, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x1011u, 1u, restore_all, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 1u) \
    X(0x1014u, 0u, emcy_cob_id, U32, RO, STATUS, 1, 1, 0u, 4294967295u, 128u) \
    X(0x1016u, 0u, consumer_heartbeat_count, U8, RO, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x1016u, 1u, host_heartbeat, U32, RW, STATUS, 0, 0, 0u, 4294967295u, 0u) \
    X(0x1017u, 0u, producer_heartbeat, U16, RW, PARAMETER, 1, 0, 0u, 60000u, 100u) \
    X(0x1018u, 0u, identity_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 4u) \
    X(0x1018u, 1u, vendor_id, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 2940u) \
    X(0x1018u, 2u, product_code, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 8209u) \
    X(0x1018u, 3u, revision_number, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 65537u) \
    X(0x1018u, 4u, serial_number, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 1u) \
    X(0x1200u, 0u, sdo_server_parameter_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 2u) \
    X(0x1200u, 1u, sdo_request_cob_id, U32, RO, STATUS, 1, 1, 0u, 4294967295u, 1536u) \
    X(0x1200u, 2u, sdo_response_cob_id, U32, RO, STATUS, 1, 1, 0u, 4294967295u, 1408u) \
    X(0x1400u, 0u, rpdo1_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 2u) \
    X(0x1400u, 1u, rpdo1_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 2147484160u) \
    X(0x1400u, 2u, rpdo1_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1401u, 0u, rpdo2_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 2u) \
    X(0x1401u, 1u, rpdo2_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 2147484416u) \
    X(0x1401u, 2u, rpdo2_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1600u, 0u, rpdo1_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1600u, 1u, rpdo1_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1600u, 2u, rpdo1_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1600u, 3u, rpdo1_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1600u, 4u, rpdo1_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1601u, 0u, rpdo2_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1601u, 1u, rpdo2_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1601u, 2u, rpdo2_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1601u, 3u, rpdo2_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1601u, 4u, rpdo2_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1800u, 0u, tpdo1_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1800u, 1u, tpdo1_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221225856u) \
    X(0x1800u, 2u, tpdo1_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1800u, 5u, tpdo1_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1801u, 0u, tpdo2_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1801u, 1u, tpdo2_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226112u) \
    X(0x1801u, 2u, tpdo2_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1801u, 5u, tpdo2_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1802u, 0u, tpdo3_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1802u, 1u, tpdo3_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226368u) \
    X(0x1802u, 2u, tpdo3_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1802u, 5u, tpdo3_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1803u, 0u, tpdo4_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1803u, 1u, tpdo4_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226624u) \
    X(0x1803u, 2u, tpdo4_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1803u, 5u, tpdo4_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1804u, 0u, tpdo5_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1804u, 1u, tpdo5_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221225920u) \
    X(0x1804u, 2u, tpdo5_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1804u, 5u, tpdo5_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1805u, 0u, tpdo6_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1805u, 1u, tpdo6_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226176u) \
    X(0x1805u, 2u, tpdo6_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1805u, 5u, tpdo6_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1806u, 0u, tpdo7_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1806u, 1u, tpdo7_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226432u) \
    X(0x1806u, 2u, tpdo7_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1806u, 5u, tpdo7_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1807u, 0u, tpdo8_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 5u) \
    X(0x1807u, 1u, tpdo8_cob_id, U32, RW, STATUS, 1, 1, 0u, 4294967295u, 3221226688u) \
    X(0x1807u, 2u, tpdo8_transmission_type, U8, RW, STATUS, 1, 0, 254u, 255u, 255u) \
    X(0x1807u, 5u, tpdo8_event_timer, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x1A00u, 0u, tpdo1_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A00u, 1u, tpdo1_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A00u, 2u, tpdo1_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A00u, 3u, tpdo1_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A00u, 4u, tpdo1_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A01u, 0u, tpdo2_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A01u, 1u, tpdo2_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A01u, 2u, tpdo2_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A01u, 3u, tpdo2_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A01u, 4u, tpdo2_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A02u, 0u, tpdo3_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A02u, 1u, tpdo3_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A02u, 2u, tpdo3_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A02u, 3u, tpdo3_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A02u, 4u, tpdo3_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A03u, 0u, tpdo4_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A03u, 1u, tpdo4_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A03u, 2u, tpdo4_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A03u, 3u, tpdo4_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A03u, 4u, tpdo4_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A04u, 0u, tpdo5_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A04u, 1u, tpdo5_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A04u, 2u, tpdo5_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A04u, 3u, tpdo5_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A04u, 4u, tpdo5_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A05u, 0u, tpdo6_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A05u, 1u, tpdo6_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A05u, 2u, tpdo6_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A05u, 3u, tpdo6_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A05u, 4u, tpdo6_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A06u, 0u, tpdo7_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A06u, 1u, tpdo7_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A06u, 2u, tpdo7_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A06u, 3u, tpdo7_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A06u, 4u, tpdo7_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A07u, 0u, tpdo8_mapping_count, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x1A07u, 1u, tpdo8_mapping_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A07u, 2u, tpdo8_mapping_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A07u, 3u, tpdo8_mapping_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x1A07u, 4u, tpdo8_mapping_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2000u, 0u, motor_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 8u) \
    X(0x2000u, 1u, pole_pairs, U8, RW, PARAMETER, 0, 0, 1u, 50u, 4u) \
    X(0x2000u, 2u, R_s, F32, RW, PARAMETER, 1, 0, 0.0f, 100.0f, 0.1f) \
    X(0x2000u, 3u, L_d, F32, RW, PARAMETER, 1, 0, 1e-06f, 1.0f, 0.01f) \
    X(0x2000u, 4u, L_q, F32, RW, PARAMETER, 1, 0, 1e-06f, 1.0f, 0.01f) \
    X(0x2000u, 5u, psi_r, F32, RW, PARAMETER, 1, 0, 0.0f, 10.0f, 0.1f) \
    X(0x2000u, 6u, J, F32, RW, PARAMETER, 1, 0, 0.0f, 1000.0f, 0.0f) \
    X(0x2000u, 7u, T_N, F32, RW, PARAMETER, 0, 0, 0.001f, 100000.0f, 1.0f) \
    X(0x2000u, 8u, omega_m_N, F32, RW, PARAMETER, 0, 0, 0.1f, 100000.0f, 100.0f) \
    X(0x2001u, 0u, sensors_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 16u) \
    X(0x2001u, 1u, encoder_lines, U32, RW, PARAMETER, 0, 0, 1u, 1000000u, 2500u) \
    X(0x2001u, 2u, encoder_offset, F32, RW, PARAMETER, 0, 0, -6.2832f, 6.2832f, 0.0f) \
    X(0x2001u, 3u, i_full_scale, F32, RO, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2001u, 4u, control_period, F32, RO, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0001f) \
    X(0x2001u, 5u, u_dc_full_scale, F32, RO, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2001u, 6u, pwm_period, F32, RO, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0001f) \
    X(0x2001u, 7u, encoder_direction, I8, RW, PARAMETER, 0, 0, -128, 127, 1) \
    X(0x2001u, 8u, phase_order, U8, RW, PARAMETER, 0, 0, 0u, 255u, 0u) \
    X(0x2001u, 9u, current_offset_a, F32, RW, PARAMETER, 0, 0, -10000.0f, 10000.0f, 0.0f) \
    X(0x2001u, 10u, current_offset_b, F32, RW, PARAMETER, 0, 0, -10000.0f, 10000.0f, 0.0f) \
    X(0x2001u, 11u, current_offset_c, F32, RW, PARAMETER, 0, 0, -10000.0f, 10000.0f, 0.0f) \
    X(0x2001u, 12u, current_gain_a, F32, RW, PARAMETER, 0, 0, 0.5f, 2.0f, 1.0f) \
    X(0x2001u, 13u, current_gain_b, F32, RW, PARAMETER, 0, 0, 0.5f, 2.0f, 1.0f) \
    X(0x2001u, 14u, current_gain_c, F32, RW, PARAMETER, 0, 0, 0.5f, 2.0f, 1.0f) \
    X(0x2001u, 15u, encoder_reference, U8, RW, PARAMETER, 0, 0, 0u, 255u, 0u) \
    X(0x2001u, 16u, angle_known, U8, RO, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x2010u, 0u, torque_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 7u) \
    X(0x2010u, 1u, law, U8, RW, PARAMETER, 0, 0, 0u, 255u, 0u) \
    X(0x2010u, 2u, u_s, F32, RW, PARAMETER, 1, 0, 0.0f, 1000.0f, 50.0f) \
    X(0x2010u, 3u, T_k_ratio, F32, RW, PARAMETER, 1, 0, 0.01f, 1.0f, 0.7f) \
    X(0x2010u, 4u, delay_compensation, U8, RW, PARAMETER, 0, 0, 0u, 1u, 1u) \
    X(0x2010u, 5u, dead_time_compensation, F32, RW, PARAMETER, 1, 0, 0.0f, 2e-05f, 0.0f) \
    X(0x2010u, 6u, flux_comparator, U8, RW, PARAMETER, 0, 0, 0u, 1u, 1u) \
    X(0x2010u, 7u, lambda_reference, U8, RW, PARAMETER, 0, 0, 0u, 1u, 1u) \
    X(0x2011u, 0u, speed_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 4u) \
    X(0x2011u, 1u, K_p_speed, F32, RW, PARAMETER, 1, 0, 0.0f, 1000.0f, 0.01f) \
    X(0x2011u, 2u, K_i_speed, F32, RW, PARAMETER, 1, 0, 0.0f, 100000.0f, 0.1f) \
    X(0x2011u, 3u, torque_limit, F32, RW, PARAMETER, 1, 0, 0.0f, 100000.0f, 1.0f) \
    X(0x2011u, 4u, omega_observer, F32, RW, PARAMETER, 1, 0, 1.0f, 5000.0f, 150.0f) \
    X(0x2012u, 0u, protection_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 9u) \
    X(0x2012u, 1u, i_trip, F32, RW, PARAMETER, 1, 0, 0.0f, 10000.0f, 10.0f) \
    X(0x2012u, 2u, omega_m_trip, F32, RW, PARAMETER, 1, 0, 0.1f, 100000.0f, 200.0f) \
    X(0x2012u, 3u, u_dc_min, F32, RW, PARAMETER, 1, 0, 0.1f, 2000.0f, 10.0f) \
    X(0x2012u, 4u, u_dc_max, F32, RW, PARAMETER, 1, 0, 0.1f, 2000.0f, 400.0f) \
    X(0x2012u, 5u, i2t_current, F32, RW, PARAMETER, 1, 0, 0.0f, 10000.0f, 10000.0f) \
    X(0x2012u, 6u, i2t_tau, F32, RW, PARAMETER, 1, 0, 0.1f, 600.0f, 30.0f) \
    X(0x2012u, 7u, i2t_level, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2012u, 8u, winding_temperature, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 25.0f) \
    X(0x2012u, 9u, temperature_trip, F32, RW, PARAMETER, 1, 0, -40.0f, 220.0f, 155.0f) \
    X(0x2013u, 0u, svm_dtc_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 2u) \
    X(0x2013u, 1u, K_p_delta, F32, RW, PARAMETER, 1, 0, 0.0f, 1000.0f, 0.05f) \
    X(0x2013u, 2u, K_i_delta, F32, RW, PARAMETER, 1, 0, 0.0f, 1000000.0f, 10.0f) \
    X(0x2014u, 0u, dtc_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 2u) \
    X(0x2014u, 1u, torque_band, F32, RW, PARAMETER, 1, 0, 0.0f, 100000.0f, 0.05f) \
    X(0x2014u, 2u, flux_band, F32, RW, PARAMETER, 1, 0, 0.0f, 10.0f, 0.001f) \
    X(0x2015u, 0u, fcs_mpc_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x2015u, 1u, flux_weight, F32, RW, PARAMETER, 1, 0, 0.0f, 1000000.0f, 1.0f) \
    X(0x2016u, 0u, foc_control_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 1u) \
    X(0x2016u, 1u, omega_current, F32, RW, PARAMETER, 1, 0, 1.0f, 100000.0f, 1000.0f) \
    X(0x2017u, 0u, current_offsets_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 3u) \
    X(0x2017u, 1u, offset_calibration, U8, RW, STATUS, 0, 0, 0u, 255u, 0u) \
    X(0x2017u, 2u, offset_calibration_state, U8, RO, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2017u, 3u, offset_calibration_ticks, U32, RW, STATUS, 1, 0, 1u, 1000000u, 4096u) \
    X(0x2020u, 0u, command_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 3u) \
    X(0x2020u, 1u, torque_command, F32, RW, COMMAND, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2020u, 2u, omega_m_command, F32, RW, COMMAND, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2020u, 3u, psi_s_command, F32, RW, COMMAND, 1, 0, 0.0f, 10.0f, 0.0f) \
    X(0x2021u, 0u, stimulus_table_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 19u) \
    X(0x2021u, 1u, stimulus_control, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2021u, 2u, stimulus_state, U8, RO, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2021u, 3u, stimulus_quantity, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2021u, 4u, stimulus_shape, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2021u, 5u, stimulus_amplitude, F32, RW, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2021u, 6u, stimulus_offset, F32, RW, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2021u, 7u, stimulus_ticks, U32, RW, STATUS, 1, 0, 1u, 1000000000u, 10000u) \
    X(0x2021u, 8u, stimulus_repetitions, U32, RW, STATUS, 1, 0, 1u, 1000000u, 1u) \
    X(0x2021u, 9u, stimulus_frequency_start, F32, RW, STATUS, 1, 0, 0.0f, 40000.0f, 1.0f) \
    X(0x2021u, 10u, stimulus_frequency_end, F32, RW, STATUS, 1, 0, 0.0f, 40000.0f, 100.0f) \
    X(0x2021u, 11u, stimulus_steps, U16, RW, STATUS, 1, 0, 1u, 10000u, 10u) \
    X(0x2021u, 12u, stimulus_prbs_clock, U32, RW, STATUS, 1, 0, 1u, 1000000u, 10u) \
    X(0x2021u, 13u, stimulus_prbs_length, U8, RW, STATUS, 1, 0, 2u, 20u, 10u) \
    X(0x2021u, 14u, stimulus_seed, U32, RW, STATUS, 1, 0, 1u, 1048575u, 1u) \
    X(0x2021u, 15u, stimulus_frame, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2021u, 16u, stimulus_angle, F32, RW, STATUS, 1, 0, -6.2832f, 6.2832f, 0.0f) \
    X(0x2021u, 17u, stimulus_start_tick, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2021u, 18u, stimulus_omega_e, F32, RW, STATUS, 1, 0, -20000.0f, 20000.0f, 0.0f) \
    X(0x2021u, 19u, stimulus_turn_ticks, U32, RW, STATUS, 1, 0, 0u, 1000000000u, 0u) \
    X(0x2030u, 0u, signals_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 22u) \
    X(0x2030u, 1u, tick, U32, RO, SIGNAL, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2030u, 2u, i_a, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 3u, i_b, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 4u, i_c, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 5u, i_d, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 6u, i_q, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 7u, u_alpha, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 8u, u_beta, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 9u, u_dc, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 10u, theta_m, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 11u, omega_m, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 12u, torque, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 13u, torque_reference, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 14u, psi_s, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 15u, psi_s_reference, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 16u, law_angle, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 17u, law_clipped, U32, RO, SIGNAL, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2030u, 18u, switching_count, U32, RO, SIGNAL, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2030u, 19u, adc_saturated, U32, RO, SIGNAL, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2030u, 20u, psi_alpha, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 21u, psi_beta, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2030u, 22u, stimulus, F32, RO, SIGNAL, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2040u, 0u, capture_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 11u) \
    X(0x2040u, 1u, capture_control, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2040u, 2u, capture_state, U8, RO, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2040u, 3u, capture_rows, U32, RW, STATUS, 1, 0, 1u, 200000u, 1000u) \
    X(0x2040u, 4u, capture_stride, U16, RW, STATUS, 1, 0, 1u, 10000u, 1u) \
    X(0x2040u, 5u, capture_pretrigger, U32, RW, STATUS, 1, 0, 0u, 199999u, 0u) \
    X(0x2040u, 6u, capture_trigger, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2040u, 7u, capture_trigger_signal, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 540019744u) \
    X(0x2040u, 8u, capture_trigger_level, F32, RW, STATUS, 1, 0, -3.4028235e+38f, 3.4028235e+38f, 0.0f) \
    X(0x2040u, 9u, capture_trigger_tick, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2040u, 10u, capture_rows_done, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2040u, 11u, capture_sequence, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 0u, capture_channels_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 16u) \
    X(0x2041u, 1u, capture_channel_1, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 2u, capture_channel_2, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 3u, capture_channel_3, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 4u, capture_channel_4, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 5u, capture_channel_5, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 6u, capture_channel_6, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 7u, capture_channel_7, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 8u, capture_channel_8, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 9u, capture_channel_9, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 10u, capture_channel_10, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 11u, capture_channel_11, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 12u, capture_channel_12, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 13u, capture_channel_13, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 14u, capture_channel_14, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 15u, capture_channel_15, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2041u, 16u, capture_channel_16, U32, RW, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2042u, 0u, capture_data, DOMAIN, RO, STATUS, 1, 0, 0, 0, 0) \
    X(0x2050u, 0u, link_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 3u) \
    X(0x2050u, 1u, link_state, U8, RO, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2050u, 2u, link_losses, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2050u, 3u, parameter_trial, U8, RW, STATUS, 1, 0, 0u, 255u, 0u) \
    X(0x2051u, 0u, process_data_count, U8, CONST, STATUS, 1, 0, 0u, 255u, 3u) \
    X(0x2051u, 1u, stream_sequence, U32, RO, SIGNAL, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2051u, 2u, rpdo_dropped, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2051u, 3u, serial_dropped, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x2060u, 0u, dictionary_hash, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 1235767694u) \
    X(0x6007u, 0u, abort_connection_option, I16, RW, PARAMETER, 0, 0, -32768, 32767, 1) \
    X(0x603Fu, 0u, error_code, U16, RO, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x6040u, 0u, controlword, U16, RW, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x6041u, 0u, statusword, U16, RO, STATUS, 1, 0, 0u, 65535u, 0u) \
    X(0x605Au, 0u, quick_stop_option, I16, RW, PARAMETER, 1, 0, -32768, 32767, 2) \
    X(0x605Du, 0u, halt_option, I16, RW, PARAMETER, 1, 0, -32768, 32767, 3) \
    X(0x605Eu, 0u, fault_reaction_option, I16, RW, PARAMETER, 1, 0, -32768, 32767, 0) \
    X(0x6060u, 0u, mode_of_operation, I8, RW, STATUS, 1, 0, -128, 127, 4) \
    X(0x6061u, 0u, mode_of_operation_display, I8, RO, STATUS, 1, 0, -128, 127, 4) \
    X(0x606Cu, 0u, velocity_actual, I32, RO, STATUS, 1, 0, (-2147483647 - 1), 2147483647, 0) \
    X(0x6071u, 0u, target_torque, I16, RW, COMMAND, 1, 0, -32768, 32767, 0) \
    X(0x6072u, 0u, max_torque, U16, RW, STATUS, 1, 0, 0u, 5000u, 1000u) \
    X(0x6075u, 0u, motor_rated_current, U32, RW, PARAMETER, 0, 0, 1u, 10000000u, 1000u) \
    X(0x6076u, 0u, motor_rated_torque, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 1000u) \
    X(0x6077u, 0u, torque_actual, I16, RO, STATUS, 1, 0, -32768, 32767, 0) \
    X(0x6078u, 0u, current_actual, I16, RO, STATUS, 1, 0, -32768, 32767, 0) \
    X(0x6079u, 0u, dc_link_voltage, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 0u) \
    X(0x60FFu, 0u, target_velocity, I32, RW, COMMAND, 1, 0, (-2147483647 - 1), 2147483647, 0) \
    X(0x6502u, 0u, supported_modes, U32, RO, STATUS, 1, 0, 0u, 4294967295u, 196620u) \
    /* end */

#define BT_ENTRY_COUNT 287u

/* What an enumeration may be: X(name, value) for each of its values, in the order of BT_ENTRIES. Any other is
 * refused. */
#define BT_VALUES(X) \
    X(encoder_direction, 1) \
    X(encoder_direction, -1) \
    X(phase_order, 0) \
    X(phase_order, 1) \
    X(encoder_reference, 0) \
    X(encoder_reference, 1) \
    X(angle_known, 0) \
    X(angle_known, 1) \
    X(law, 0) \
    X(law, 1) \
    X(law, 2) \
    X(law, 3) \
    X(law, 4) \
    X(law, 5) \
    X(law, 6) \
    X(delay_compensation, 0) \
    X(delay_compensation, 1) \
    X(flux_comparator, 0) \
    X(flux_comparator, 1) \
    X(lambda_reference, 0) \
    X(lambda_reference, 1) \
    X(offset_calibration, 0) \
    X(offset_calibration, 1) \
    X(offset_calibration_state, 0) \
    X(offset_calibration_state, 1) \
    X(offset_calibration_state, 2) \
    X(offset_calibration_state, 3) \
    X(stimulus_control, 0) \
    X(stimulus_control, 1) \
    X(stimulus_state, 0) \
    X(stimulus_state, 1) \
    X(stimulus_state, 2) \
    X(stimulus_quantity, 0) \
    X(stimulus_quantity, 1) \
    X(stimulus_quantity, 2) \
    X(stimulus_quantity, 3) \
    X(stimulus_quantity, 4) \
    X(stimulus_shape, 0) \
    X(stimulus_shape, 1) \
    X(stimulus_shape, 2) \
    X(stimulus_shape, 3) \
    X(stimulus_shape, 4) \
    X(stimulus_shape, 5) \
    X(stimulus_shape, 6) \
    X(stimulus_shape, 7) \
    X(stimulus_frame, 0) \
    X(stimulus_frame, 1) \
    X(capture_control, 0) \
    X(capture_control, 1) \
    X(capture_state, 0) \
    X(capture_state, 1) \
    X(capture_state, 2) \
    X(capture_state, 3) \
    X(capture_state, 4) \
    X(capture_trigger, 0) \
    X(capture_trigger, 1) \
    X(capture_trigger, 2) \
    X(capture_trigger, 3) \
    X(capture_trigger, 4) \
    X(capture_trigger, 5) \
    X(link_state, 0) \
    X(link_state, 1) \
    X(link_state, 2) \
    X(link_state, 3) \
    X(parameter_trial, 0) \
    X(parameter_trial, 1) \
    X(abort_connection_option, 1) \
    X(abort_connection_option, 2) \
    X(abort_connection_option, 3) \
    X(quick_stop_option, 0) \
    X(quick_stop_option, 2) \
    X(quick_stop_option, 5) \
    X(quick_stop_option, 6) \
    X(halt_option, 3) \
    X(fault_reaction_option, 0) \
    X(mode_of_operation, -2) \
    X(mode_of_operation, -1) \
    X(mode_of_operation, 3) \
    X(mode_of_operation, 4) \
    X(mode_of_operation_display, -2) \
    X(mode_of_operation_display, -1) \
    X(mode_of_operation_display, 3) \
    X(mode_of_operation_display, 4) \
    /* end */

#define BT_VALUE_COUNT 83u

/* Entries that another's value limits as well: X(name, least, times) with the limit least * times, and
 * X(name, most, times) with the limit most * times. A limit of 0 is not known, and none. */
#define BT_MIN_ENTRIES(X) \
    X(u_dc_min, u_dc_full_scale, 0.015625f) \
    X(u_dc_max, u_dc_min, 1.0f) \
    /* end */
#define BT_MAX_ENTRIES(X) \
    X(i_trip, i_full_scale, 1.0f) \
    X(omega_m_trip, omega_m_N, 10.0f) \
    X(u_dc_min, u_dc_max, 1.0f) \
    X(u_dc_max, u_dc_full_scale, 1.0f) \
    X(i2t_current, i_full_scale, 1.0f) \
    /* end */

#ifdef __cplusplus
}
#endif

#endif
