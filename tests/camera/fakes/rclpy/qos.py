# SPDX-License-Identifier: Apache-2.0
qos_profile_sensor_data = "sensor data"
