!> What a calibration by Level-1 data gives.
module gracecg_level1_outcome
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: string_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_action, only: action_t
    use gracecg_estimation_arcs, only: arc_residuals_t
    use gracecg_estimation_offset_movement, only: movement_t
    use gracecg_level1_solution, only: level1_solution_t
    implicit none
    private
    public :: level1_estimate_t, rod_calibration_t, milliseconds, LEVEL1_SOURCES

    !> What is estimated: by all instruments, the result; without the gyros; without the angular channels of the accelerometer
    character(11), parameter :: LEVEL1_SOURCES(3) = [character(11) :: 'optimal', 'no-gyros', 'no-channels']

    type :: rod_calibration_t
        !! What the samples say of the rods
        logical :: driven(3) = .false.      !! Some span drives the rod: it has a gain
        real(dp) :: gain(3) = 1             !! Of the moment said
        real(dp) :: gain_sigma(3) = 0       !! That of the inertia in it
        real(dp) :: delay = 0               !! Of the torque behind the currents' tags, s
        real(dp) :: delay_sigma = 0         !! s
    end type rod_calibration_t

    type :: level1_estimate_t
        !! The result of a calibration
        type(rod_calibration_t) :: rods                     !! Gains and delay
        logical :: steps = .false.                          !! Currents are held from tag to tag
        logical :: settled = .false.                        !! The fit did
        real(dp) :: accelerometer_delay = 0                 !! s
        real(dp) :: accelerometer_delay_sigma = 0           !! s; 0: not estimated
        type(observation_set_t), allocatable :: arcs(:)     !! What was fitted
        integer, allocatable :: span_of(:)                  !! The span of each arc
        logical, allocatable :: disturbed(:)                !! Arcs that count less, for their noise is larger
        type(movement_t) :: movement                        !! Of d over a day on which rods are driven all the time
        type(arc_residuals_t), allocatable :: residuals(:)  !! Of each arc
        real(dp) :: head_sigma(3) = 0                       !! Of the star cameras about the axes, rad
        type(level1_solution_t), allocatable :: solutions(:)    !! By source, the result first
        type(string_t), allocatable :: findings(:)          !! What is wrong, by name
        type(string_t), allocatable :: remarks(:)           !! What is to be known
        integer :: flag = 2                                 !! Of the first solution
        type(action_t) :: action                            !! What to do
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
