!> What a calibration by Level-1 data gives: offsets, and what each rests on.
module gracecg_level1_outcome
    use gracecg_level1_basics
    use gracecg_estimation_action, only: action_t
    use gracecg_estimation_arc_problem, only: arc_residuals_t
    use gracecg_estimation_belief_report, only: belief_report_t
    use gracecg_estimation_offset_movement, only: movement_t
    use gracecg_observations_observation_set, only: observation_set_t
    implicit none
    private
    public :: WORST_CONDITION, level1_solution_t, sigma_of, level1_estimate_t, rod_calibration_t, milliseconds, LEVEL1_SOURCES

    real(dp), parameter :: WORST_CONDITION = 1e6_dp     !! Of the scaled normal matrix: a greater one separates nothing

    type :: level1_solution_t
        !! An offset with what it rests on
        character(12) :: source = ''                    !! Of LEVEL1_SOURCES
        character(12) :: leakage = ''                   !! estimated or a priori
        logical :: separable = .false.                  !! Whether the samples tell leakage from d
        real(dp) :: offset(3) = 0                       !! d, m, SRF
        real(dp) :: covariance(3, 3) = 0                !! m^2
        real(dp) :: leak(3, 3) = 0, leak_sigma(3, 3) = 0            !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0, leak_rate_sigma(3, 3) = 0  !! K, m/s^2/(mA/s)
        real(dp) :: sigma_alone(3) = 0                  !! Of d if no leakage is estimated, m
        real(dp) :: sigma_free(3) = 0                   !! If it is estimated without a-priori sigma, m; huge: cannot be
        real(dp) :: condition = 0                       !! Of the scaled normal matrix with leakage, without a-priori sigma
        character(160) :: weakest = ''                  !! Direction that the data determine least
        real(dp) :: rms(3) = 0                          !! Of the accelerometer's noise, m/s^2
        integer :: samples = 0, spans = 0    !! That are used
        real(dp), allocatable :: span_offset(:, :)      !! By each span alone with the leakage of all, m
        real(dp), allocatable :: span_covariance(:, :, :)   !! (3, 3, spans), m^2; 0: not determined
        real(dp), allocatable :: span_rms(:, :)         !! Likewise, of each span
        real(dp) :: chi_square = 0                      !! Of the spans about the combined offset
        integer :: degrees = 0                          !! Of freedom of it
        type(belief_report_t), allocatable :: beliefs   !! What the samples say of the setup; of the first alone
        integer :: flag = 2                             !! 0 good, 1 with care, 2 not to be used
        character(200) :: reason = ''                   !! Why not 0
    end type level1_solution_t

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
        real(dp) :: inertia(3, 3) = 0                       !! That was used, with products that were estimated, kg m^2
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

    !> Standard deviations of the offset.
    pure function sigma_of(solution, span) result(sigma)
        type(level1_solution_t), intent(in) :: solution
        integer, intent(in), optional :: span   !! By that alone; 0: it does not determine it. Absent: of all
        real(dp) :: sigma(3)                    !! m

        integer :: k

        if (present(span)) then
            sigma = sqrt([(solution%span_covariance(k, k, span), k=1, 3)])
        else
            sigma = sqrt([(solution%covariance(k, k), k=1, 3)])
        end if
    end function sigma_of

    !> A time in milliseconds, to a tenth, with blanks behind it.
    pure function milliseconds(time) result(text)
        real(dp), intent(in) :: time        !! s
        character(24) :: text

        write (text, '(f24.1)') time*1e3_dp
        text = adjustl(text)
    end function milliseconds
end module gracecg_level1_outcome
