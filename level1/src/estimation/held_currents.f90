!> Currents of the rods that are held from tag to tag: whether the angular channels of the accelerometer show their steps.
module gracecg_level1_held_currents
    use gracecg_level1_basics
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moment, rod_moments
    use gracecg_level1_series, only: interpolate
    use gracecg_level1_setup, only: QUIETEST
    implicit none
    private
    public :: find_steps, rod_accelerations

contains

    !> What share of the steps the channels show, and how long behind the currents' tags.
    !>
    !> A step is seen between two samples, wherever it is there, and tags drift slowly through the steps: the delay is the middle
    !> of those that are as good as the best but for chance. Linear channels count, too: leakage by the currents' rate shows in
    !> the sample in whose interval a step lies. What a moving mean of samples does not follow is compared with the same of the
    !> moments and, of linear channels, of their rates, each arc and axis alone.
    subroutine find_steps(arcs, share, delay)
        type(observation_set_t), intent(in) :: arcs(:)      !! With all samples
        real(dp), intent(out) :: share                      !! 1, if they are held; 0, if they are smooth
        real(dp), intent(out) :: delay                      !! Of torque and samples together, s

        integer, parameter :: REACH = 25, BESIDE = 30       ! Steps of the searches
        real(dp), parameter :: COARSE = 0.02_dp, FINE = 0.002_dp        ! s
        real(dp), parameter :: BY_CHANCE = 4                ! Two sigma
        real(dp) :: coarsely(-REACH:REACH), finely(-BESIDE:BESIDE), middle
        integer :: i, low, high

        coarsely = [(unlikeliness(arcs, i*COARSE), i=-REACH, REACH)]
        middle = (minloc(coarsely, 1) - REACH - 1)*COARSE
        finely = [(unlikeliness(arcs, middle + i*FINE), i=-BESIDE, BESIDE)]
        low = minloc(finely, 1) - BESIDE - 1
        high = low
        do while (low > -BESIDE)
            if (finely(low - 1) > minval(finely) + BY_CHANCE) exit
            low = low - 1
        end do
        do while (high < BESIDE)
            if (finely(high + 1) > minval(finely) + BY_CHANCE) exit
            high = high + 1
        end do
        delay = middle + (low + high)*FINE/2
        share = share_of_steps(arcs, delay)
    end subroutine find_steps

    !> Twice the logarithm of the likelihood of held moments with some delay, but for its sign and a constant.
    function unlikeliness(arcs, delay) result(sum_of_logarithms)
        type(observation_set_t), intent(in) :: arcs(:)
        real(dp), intent(in) :: delay               !! s
        real(dp) :: sum_of_logarithms

        real(dp), parameter :: LEAST_ANGULAR = 1e-8_dp      ! rad/s^2: a quantum
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp), allocatable :: columns(:, :), samples(:, :)
        real(dp) :: normal(6, 6), rhs(6), x(6), covariance(6, 6), condition, left
        integer, allocatable :: driven(:)
        integer :: arc, axis, k

        sum_of_logarithms = 0
        do arc = 1, size(arcs)
            associate (set => arcs(arc))
                rods = set%knowledge%rods
                rods%measured%held = .true.
                rods%delay = delay
                allocate (columns(6, size(set%accelerometer_time)))
                do k = 1, size(columns, 2)
                    associate (t => set%accelerometer_time(k), half => set%knowledge%accelerometer_interval/2)
                        columns(:3, k) = rod_moments(rods, t, .true.)
                        columns(4:, k) = rod_moments(rods, t + half, .true.) - rod_moments(rods, t - half, .true.)
                    end associate
                end do
                columns = rapid(columns)
                samples = rapid(reshape([transpose(set%acceleration), transpose(set%angular_acceleration)], &
                                        [6, size(columns, 2)], order=[2, 1]))
            end associate
            driven = pack([1, 2, 3], sum(columns(:3, :)**2, 2) > 0)
            columns = columns([driven, driven + 3], :)
            do axis = 1, 6
                associate (n => merge(2, 1, axis <= 3)*size(driven))    ! with rates, angular ones would not tell sample from sample
                    call normal_equations(columns(:n, :), samples(axis, :), normal(:n, :n), rhs(:n))
                    call solve_normal_equations(normal(:n, :n), rhs(:n), x(:n), covariance(:n, :n), condition, failure)
                    left = sum(samples(axis, :)**2)
                    if (.not. allocated(failure)) left = left - dot_product(x(:n), rhs(:n))
                end associate
                left = left + size(columns, 2)*merge(QUIETEST, LEAST_ANGULAR, axis <= 3)**2
                sum_of_logarithms = sum_of_logarithms + size(columns, 2)*log(left)
            end do
            deallocate (columns)
        end do
    end function unlikeliness

    !> The share of the steps of held moments that the channels show.
    real(dp) function share_of_steps(arcs, delay) result(share)
        type(observation_set_t), intent(in) :: arcs(:)
        real(dp), intent(in) :: delay               !! s

        real(dp), allocatable :: model(:, :)
        type(torque_rods_t) :: rods
        real(dp) :: product, square
        integer :: arc

        product = 0
        square = tiny(square)
        do arc = 1, size(arcs)
            associate (set => arcs(arc))
                rods = set%knowledge%rods
                rods%measured%held = .true.
                rods%delay = delay
                model = rapid(rod_accelerations(set, rods, set%accelerometer_time, .true.))
                product = product + sum(model*rapid(set%angular_acceleration))
                square = square + sum(model**2)
            end associate
        end do
        share = product/square
    end function share_of_steps

    !> What of samples their moving mean does not follow; none at the ends, where currents are not known on both sides.
    pure function rapid(samples)
        real(dp), intent(in) :: samples(:, :)       !! (3, n)
        real(dp) :: rapid(size(samples, 1), size(samples, 2))

        integer, parameter :: HALF = 2, ENDS = 10   ! Samples
        integer :: k

        rapid = 0
        do k = 1 + ENDS, size(samples, 2) - ENDS
            rapid(:, k) = samples(:, k) - sum(samples(:, k - HALF:k + HALF), 2)/(2*HALF + 1)
        end do
    end function rapid

    !> The angular accelerations J^-1 m x B by some rods at times of an arc, rad/s^2.
    pure function rod_accelerations(set, rods, times, at_once) result(accelerations)
        type(observation_set_t), intent(in) :: set
        type(torque_rods_t), intent(in) :: rods
        real(dp), intent(in) :: times(:)            !! s from the begin of the arc
        logical, intent(in) :: at_once              !! Held moments jump
        real(dp) :: accelerations(3, size(times))

        real(dp) :: field(3), inverse(3, 3)
        integer :: k

        inverse = inverse_3x3(set%knowledge%inertia)
        do k = 1, size(times)
            call interpolate(set%magnetometer_time, set%field, times(k), field)
            accelerations(:, k) = matmul(inverse, cross(dipole_moment(rods, times(k), at_once), field))
        end do
    end function rod_accelerations
end module gracecg_level1_held_currents
