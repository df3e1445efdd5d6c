!> Level-1 data of GRACE and GRACE-FO as a library: everything of it that a program may want, by one `use gracecg_level1`
!> beside `use gracecg`.
!>
!> - files, text and binary: `read_level1`, `level1_reader_t`, `level1_writer_t`, `convert_level1`
!> - their time and frames: `level1_clock_t`, `to_gps_time`, `srf_of_accelerometer`
!> - a folder of files: `open_level1_folder`, `check_level1`
!> - the CG offset from them: `gather_calibration`, `estimate_level1`; `estimate_driven_day`
module gracecg_level1
    use gracecg_level1_products, only: level1_layout_t, level1_layout, level1_product_names
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_writer, only: level1_writer_t
    use gracecg_level1_conversion, only: convert_level1, exchange_level1
    use gracecg_level1_time, only: level1_clock_t, new_level1_clock, to_gps_time, gps_date_text
    use gracecg_level1_frames, only: srf_of_accelerometer, ACCELEROMETER_AXES, gracecg_quaternion, &
        continuous_quaternions, mounting_of_head, attitude_by_head, calibration_vector, &
        inertial_of_earth_fixed_by_states, inertial_of_earth_fixed, inertial_velocity
    use gracecg_level1_folder, only: level1_folder_t, open_level1_folder
    use gracecg_level1_check, only: level1_check_t, check_level1
    use gracecg_level1_setup, only: level1_setup_t, read_level1_setup
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_driven_day, only: estimate_driven_day
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_outcome, only: level1_estimate_t, LEVEL1_SOURCES, level1_solution_t
    implicit none
    private

    public :: level1_layout_t, level1_layout, level1_product_names, level1_header_t, level1_reader_t, level1_block_t
    public :: level1_records_t, read_level1, level1_writer_t, convert_level1, exchange_level1
    public :: level1_clock_t, new_level1_clock, to_gps_time, gps_date_text
    public :: srf_of_accelerometer, ACCELEROMETER_AXES, gracecg_quaternion, continuous_quaternions, mounting_of_head
    public :: attitude_by_head, calibration_vector, inertial_of_earth_fixed_by_states, inertial_of_earth_fixed
    public :: inertial_velocity, level1_folder_t, open_level1_folder, level1_check_t, check_level1
    public :: level1_setup_t, read_level1_setup, level1_calibration_t, gather_calibration
    public :: level1_estimate_t, estimate_level1, estimate_driven_day, LEVEL1_SOURCES, level1_solution_t
end module gracecg_level1
