!> What the samples of one calibration say of the offset and of what several calibrations have in common: the
!> information about them, from which a joint estimate is made without the samples.
!>
!> It is about x - x*, x the values of JOINED, the parameters that runs can have in common, and x* the point about which
!> the fit was linearised, all that belongs to the run alone at its best (gracecg_estimation_information). It is of the
!> samples alone: a-priori knowledge of JOINED is not in it, so that it can be counted once.
module gracecg_estimation_run_information
    use gracecg_base_kinds, only: dp
    use gracecg_environment_time, only: utc_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters, only: OFFSET, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS, INERTIA
    use gracecg_estimation_information, only: information_t
    implicit none
    private
    public :: run_information_t, JOINED, JOINED_COUNT, SHARED_GROUPS, GROUP_OF_JOINED
    public :: beliefs_of, GROUP_OF_BELIEF

    !> Parameters that several runs can share: the offset first, then by SHARED_GROUPS
    integer, parameter :: JOINED(*) = [OFFSET, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS, INERTIA]
    integer, parameter :: JOINED_COUNT = size(JOINED), BELIEFS_COUNT = 15   !! Number of these, and of values of `beliefs_of`
    !> Properties of the satellite, which runs share unless they are told not to
    character(18), parameter :: SHARED_GROUPS(4) = [character(18) :: 'scale-factors', 'rod-gain', 'magnetometer-bias', &
                                                    'inertia']
    !> The group of each of JOINED; 0: the offset
    integer, parameter :: GROUP_OF_JOINED(JOINED_COUNT) = [0, 0, 0, 1, 1, 1, 2, 3, 3, 3, 4, 4, 4, 4, 4, 4]
    !> The group of each value of `beliefs_of`
    integer, parameter :: GROUP_OF_BELIEF(BELIEFS_COUNT) = [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4, 4]

    type, extends(information_t) :: run_information_t
        !! Of one run
        character(64) :: name = ''          !! Of the calibration
        type(utc_t) :: epoch    !! Time 0 of the run, UTC
        real(dp) :: point(JOINED_COUNT) = 0                 !! x*, SI units
        integer :: redundancy = 0           !! Observations less the parameters of the run alone
        logical :: estimated(JOINED_COUNT) = .false.        !! In the run's own estimate
        real(dp) :: prior_sigma(JOINED_COUNT) = 0           !! A-priori knowledge, SI units; 0: none
        real(dp), allocatable :: own_by_joined(:, :)
        !! How the parameters of the run alone follow JOINED in the best fit, by SI units; not saved
        real(dp) :: belief(BELIEFS_COUNT) = 0   !! What JOINED beside the offset are errors of
    end type run_information_t

contains

    !> What the operator believes of scale factors, rods' gains, magnetometer bias (T) and inertia (kg m^2: xx, yy,
    !> zz, xy, yz, zx): runs can share errors only of the same beliefs.
    pure function beliefs_of(knowledge) result(belief)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp) :: belief(BELIEFS_COUNT)

        associate (j => knowledge%inertia)
            belief = [knowledge%accelerometer_scale, knowledge%rods%gain, knowledge%magnetometer_bias, &
                      j(1, 1), j(2, 2), j(3, 3), j(1, 2), j(2, 3), j(1, 3)]
        end associate
    end function beliefs_of
end module gracecg_estimation_run_information
