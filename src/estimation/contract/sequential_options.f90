!> What the user says of the estimator `sequential`: how the non-gravitational acceleration may depart
!> from a straight line, and when a sample is edited.
module gracecg_estimation_sequential_options
    use gracecg_base_kinds, only: dp
    use gracecg_files_settings, only: settings_t
    implicit none
    private
    public :: sequential_options_t, describe_sequential, ADAPTIVE, STRAIGHT_LINE, GIVEN

    character(*), parameter :: ADAPTIVE = 'adaptive', STRAIGHT_LINE = 'straight-line', GIVEN = 'given'
    !! Values of `acceleration`

    !> The settings of group `sequential`.
    type :: sequential_options_t
        character(16) :: acceleration = ADAPTIVE
        !! Beside bias and drift: a parabola along the airflow, and second-order Gauss-Markov processes whose
        !! size, period and damping the likelihood of the innovations tells (adaptive) or the one below
        !! (given); nothing (straight-line)
        real(dp) :: process_sigma(3) = 0            !! Of the given process by axis, m/s^2; 0: none
        real(dp) :: process_period = 12             !! Of its undamped oscillation, s
        real(dp) :: process_damping = 1             !! Its damping ratio, 0 < zeta <= 1
        real(dp) :: likelihood_gain = 10            !! Of 2 ln L, that an adaptive process must bring
        real(dp) :: shared_part = 0.013_dp
        !! Of the process found in one axis the others see a part, as drag acts along the airflow. Its
        !! standard deviation about that of the air that turns with the Earth: 0.013 for the eastward wind of
        !! HWM93 along polar orbits, 100 m/s RMS (data/wind_hwm93_1989-01-02.txt)
        logical :: estimate_within_limits = .true.
        !! Scale factors and magnetometer bias, which are known within their a-priori sigmas only
        real(dp) :: edit_sigma = 5                  !! A sample farther off is edited, standard deviations
    end type sequential_options_t

contains

    !> The group `sequential` of a case file and of setup.nml.
    subroutine describe_sequential(settings, sequential)
        class(settings_t), intent(inout) :: settings
        type(sequential_options_t), intent(inout) :: sequential

        real(dp), parameter :: SMALLEST = 1e-3_dp

        call settings%group('sequential', 'The estimator sequential: non-gravitational acceleration, editing')
        call settings%text_value('acceleration', sequential%acceleration, &
                                 'beside the straight line: a parabola and processes found from the data, nothing, or '// &
                                 'a parabola and a given process', &
                                 [character(13) :: ADAPTIVE, STRAIGHT_LINE, GIVEN])
        call settings%real_values('process_sigma', sequential%process_sigma, 0.0_dp, 1e-3_dp, &
                                  'm/s^2, of the given process by axis; 0: none', unit='m/s^2')
        call settings%real_value('process_period', sequential%process_period, 0.1_dp, 1e5_dp, &
                                 's, of the given process', unit='s')
        call settings%real_value('process_damping', sequential%process_damping, SMALLEST, 1.0_dp, &
                                 'damping ratio of the given process: 1 a smooth wander, small an oscillation')
        call settings%real_value('likelihood_gain', sequential%likelihood_gain, 0.0_dp, 1e6_dp, &
                                 'of 2 ln L, that a process found from the data must bring')
        call settings%real_value('shared_part', sequential%shared_part, 1e-6_dp, 10.0_dp, &
                                 'sigma of the part of a process found in one axis that the others see, about that '// &
                                 'of an acceleration along the airflow')
        call settings%logical_value('estimate_within_limits', sequential%estimate_within_limits, &
                                    'scale factors and magnetometer bias, within their a-priori sigmas')
        call settings%real_value('edit_sigma', sequential%edit_sigma, 3.0_dp, 1e6_dp, &
                                 'samples farther off than so many standard deviations are edited')
        call settings%end_group()
    end subroutine describe_sequential
end module gracecg_estimation_sequential_options
