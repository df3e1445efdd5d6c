!> What a calibration by Level-1 data gives.
module gracecg_level1_outcome
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: string_t
    use gracecg_level1_angular, only: level1_motion_t, angular_calibration_t
    use gracecg_level1_attitude, only: rod_calibration_t
    use gracecg_level1_drive, only: level1_drive_t
    use gracecg_level1_gyros, only: gyro_axes_t
    use gracecg_level1_offset_solution, only: level1_solution_t
    implicit none
    private
    public :: level1_estimate_t, milliseconds

    type :: level1_estimate_t
        !! The result of a calibration
        type(rod_calibration_t) :: rods    !! Gains and delay of the rods
        type(level1_drive_t) :: drive                       !! Currents at any time
        logical :: steps = .false.                          !! Currents are held from tag to tag
        real(dp) :: accelerometer_delay = 0                 !! s
        real(dp) :: accelerometer_delay_sigma = 0           !! s; 0: not estimated
        type(angular_calibration_t) :: angular    !! The angular channels
        type(gyro_axes_t) :: gyros    !! Axes of the gyros
        type(level1_motion_t), allocatable :: motion(:)     !! Of each span, by the recommended source
        type(level1_solution_t), allocatable :: solutions(:)    !! By source, the recommended one first
        type(string_t), allocatable :: findings(:)          !! What is wrong, by name
        type(string_t), allocatable :: remarks(:)           !! What is to be known
        integer :: flag = 2                                 !! Of the first solution
    end type level1_estimate_t

contains

    !> A time in milliseconds, to a tenth, with blanks behind it.
    pure function milliseconds(time) result(text)
        real(dp), intent(in) :: time        !! s
        character(24) :: text

        write (text, '(f24.1)') time*1e3_dp
        text = adjustl(text)
    end function milliseconds
end module gracecg_level1_outcome
