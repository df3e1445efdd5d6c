!> What an operator believes of satellite, rods and instruments, as hypotheses that a fit can contradict: a list
!> of them, in words, and what an observation set looks like if another value holds.
!>
!> A belief with a value (a gain, a delay, an angle) is a parameter of gracecg_observations_parameters whose value 0
!> is what is believed. A belief without one (which axis is which, a sign, a convention) is an alteration.
module gracecg_estimation_belief
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion
    use gracecg_base_vectors, only: cross
    use gracecg_spacecraft_torque_rods, only: interchange_rods, gain_unit
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_knowledge, only: HEADS, operator_knowledge_t
    use gracecg_observations_parameters
    use gracecg_estimation_interpolation, only: lagrange_weights
    use gracecg_estimation_physical_model, only: turned_by, sinc
    implicit none
    private
    public :: ALTERATIONS, OF_QUATERNIONS, apply_value, apply_alteration, is_possible

    integer, parameter :: REACH = 32    !! Samples on each side from which one between them is interpolated
    integer, parameter :: FEWEST = 4    !! Of them: with fewer a cubic is as good
    real(dp), parameter :: NO_TURN(4) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
    !> All beliefs without a value: what would have to hold instead. apply_alteration knows them by their place
    character(52), parameter :: ALTERATIONS(23) = [character(52) :: &
        'rod x has the opposite sign', 'rod y has the opposite sign', 'rod z has the opposite sign', &
        'all rods have the opposite sign', &
        'rods x and y are interchanged', 'rods y and z are interchanged', 'rods z and x are interchanged', &
        'accelerometer x has the opposite sign', 'accelerometer y has the opposite sign', &
        'accelerometer z has the opposite sign', &
        'accelerometer x and y are interchanged', 'accelerometer y and z are interchanged', &
        'accelerometer z and x are interchanged', &
        'magnetometer x has the opposite sign', 'magnetometer y has the opposite sign', &
        'magnetometer z has the opposite sign', &
        'magnetometer x and y are interchanged', 'magnetometer y and z are interchanged', &
        'magnetometer z and x are interchanged', &
        'the star-camera heads are interchanged', 'the quaternions turn from the camera to inertial', &
        'the quaternions have the scalar first', 'scalar first, from the camera to inertial']
    integer, parameter :: OF_QUATERNIONS(4) = [20, 21, 22, 23]      !! Those of ALTERATIONS about the star camera

contains

    !> Can a belief have a value? Moments of inertia are positive, and none is more than the sum of the two others.
    pure logical function is_possible(parameter, value, knowledge)
        integer, intent(in) :: parameter    !! Its place
        real(dp), intent(in) :: value       !! SI units
        type(operator_knowledge_t), intent(in) :: knowledge     !! What is believed

        real(dp) :: moments(3)
        integer :: i

        is_possible = .true.
        if (all(INERTIA(:3) /= parameter)) return
        moments = [(knowledge%inertia(i, i), i=1, 3)]
        moments(MEMBER_OF(parameter)) = moments(MEMBER_OF(parameter)) + value
        is_possible = all(moments > 0) .and. 2*maxval(moments) <= sum(moments)
    end function is_possible

    !> Makes an observation set in which the parameter of a belief is 0 of one in which it has a value: knowledge or
    !> samples change. An interchange is done if the value is not 0, whatever it is. By a delay of an axis of the
    !> accelerometer epochs at an end may be lost.
    pure subroutine apply_value(parameter, value, observations, noise_follows)
        integer, intent(in) :: parameter    !! Its place
        real(dp), intent(in) :: value       !! SI units
        type(observation_set_t), intent(inout) :: observations
        logical, intent(in), optional :: noise_follows
        !! Whether the levels of the accelerometer's noise become those of the samples as they then are: a scale factor
        !! divides their noise, too, and interpolation smooths it. Fits under the belief can be compared only so

        integer :: i, j, next
        real(dp) :: other, noise
        logical :: follows

        follows = .false.
        if (present(noise_follows)) follows = noise_follows
        i = MEMBER_OF(parameter)
        next = modulo(i, 3) + 1
        associate (k => observations%knowledge)
            select case (KIND_OF(parameter))
            case (ROD_GAIN)
                k%rods%gain = k%rods%gain*(1 + value)
            case (ROD_GAINS(1))
                k%rods%gain(i) = k%rods%gain(i) + value*gain_unit(k%rods%gain(i))
            case (ROD_TURNS(1))
                k%rods%misalignment(i) = k%rods%misalignment(i) + value
            case (ROD_DELAYS(1))
                k%rods%delay(i) = k%rods%delay(i) + value
            case (ALL_RODS_DELAY)
                k%rods%delay = k%rods%delay + value
            case (ALL_RODS_FREQUENCY)
                k%rods%activations%frequency = k%rods%activations%frequency + value
            case (ROD_FREQUENCIES(1))
                where (k%rods%activations%axis == i) k%rods%activations%frequency = k%rods%activations%frequency + value
            case (INERTIA(1))
                associate (row => mod(i - 1, 3) + 1, column => merge(i, next, i <= 3))
                    k%inertia(row, column) = k%inertia(row, column) + value
                    k%inertia(column, row) = k%inertia(row, column)
                end associate
            case (TORQUE_CHANGE(1))
                k%torque_change(i) = k%torque_change(i) + value
            case (SCALE_FACTORS(1))
                k%accelerometer_scale(i) = k%accelerometer_scale(i)*(1 + value)
                if (follows) k%accelerometer_noise(i)%level = k%accelerometer_noise(i)%level/(1 + value)**2
            case (FIELD_BIAS(1))
                k%magnetometer_bias(i) = k%magnetometer_bias(i) + value
            case (FIELD_SCALES(1))
                observations%field(i, :) = observations%field(i, :)*(1 - value)
            case (FIELD_SHEARS(1))
                do j = 1, size(observations%field, 2)
                    other = observations%field(i, j)
                    observations%field(i, j) = cosh(value)*other - sinh(value)*observations%field(next, j)
                    observations%field(next, j) = cosh(value)*observations%field(next, j) - sinh(value)*other
                end do
            case (ROD_SWAPS(1))
                if (abs(value) > 0) call apply_alteration(4 + i, observations)
            case (ACCELEROMETER_SWAPS(1))
                if (abs(value) > 0) call apply_alteration(10 + i, observations)
            case (FIELD_SWAPS(1))
                if (abs(value) > 0) call apply_alteration(16 + i, observations)
            case (FIELD_DELAY)
                observations%magnetometer_time = observations%magnetometer_time - value
            case (STAR_CAMERA_DELAY)
                observations%star_camera_time = observations%star_camera_time - value
            case (ACCELEROMETER_DELAYS(1))
                call advance(observations%accelerometer_time, observations%acceleration(i, :), value, noise)
                do j = 1, k%line%number - 1
                    call advance(observations%accelerometer_time, observations%further_acceleration(i, :, j), value, noise)
                end do
                if (follows) k%accelerometer_noise(i)%level = k%accelerometer_noise(i)%level*noise
                call leave_out_beyond(value, observations)
            case (FIELD_TURN(1))
                call turn(observations%field, along(i, value))
            case (ACCELEROMETER_TURN(1))
                call turn(observations%acceleration, -along(i, value))
                do j = 1, k%line%number - 1
                    call turn(observations%further_acceleration(:, :, j), -along(i, value))
                end do
            case (MOUNTING_1(1), MOUNTING_2(1))
                ! body from inertial, as the samples say it, is turned too far: the camera's mounting takes it up
                associate (mounting => k%mounting(:, merge(1, 2, any(MOUNTING_1 == parameter))))
                    mounting = quaternion_product(mounting, conjugate_quaternion(turned_by(-along(i, value), NO_TURN)))
                end associate
            end select
        end associate
    end subroutine apply_value

    pure function along(axis, value) result(vector)
        integer, intent(in) :: axis
        real(dp), intent(in) :: value
        real(dp) :: vector(3)

        vector = 0
        vector(axis) = value
    end function along

    !> Turns vectors by a rotation vector (R. Rodrigues).
    pure subroutine turn(vectors, zeta)
        real(dp), intent(inout) :: vectors(:, :)
        real(dp), intent(in) :: zeta(3)

        real(dp) :: angle, axis(3), v(3)
        integer :: i

        angle = norm2(zeta)
        if (.not. angle > 0) return
        axis = zeta/angle
        do i = 1, size(vectors, 2)
            v = vectors(:, i)
            vectors(:, i) = v*cos(angle) + cross(axis, v)*sin(angle) + axis*dot_product(axis, v)*(1 - cos(angle))
        end do
    end subroutine turn

    !> A series read at later tags: the value at t + delay. Where samples about it are equally spaced, by the sine cardinal
    !> under Hann's window (F. J. Harris, Proc. IEEE 66 (1978) 51-83), which leaves the level of white noise and its
    !> colour nearly as they are, as a delay does; elsewhere by Lagrange's cubic through the four nearest samples. Beyond
    !> an end the series is a straight line for an interval, and then stays.
    pure subroutine advance(times, series, delay, noise)
        real(dp), intent(in) :: times(:)        !! Increasing, s
        real(dp), intent(inout) :: series(:)
        real(dp), intent(in) :: delay           !! s
        real(dp), intent(out) :: noise          !! Variance that is left of white noise of variance 1

        real(dp) :: old(size(series)), weights(2*REACH), t
        integer :: i, k, n, many

        n = size(series)
        noise = 1
        if (n < 4) return
        noise = 0
        old = series
        do i = 1, n
            t = min(max(times(i) + delay, 2*times(1) - times(2)), 2*times(n) - times(n - 1))
            k = max(1, min(n - 1, last_not_after(times, t)))
            many = min(REACH, k, n - k)
            if (many < FEWEST .or. .not. is_even(times, k, many)) many = 2
            associate (first => max(1, min(k - many + 1, n - 2*many + 1)), w => weights(:2*many))
                if (many == 2) then
                    call cubic_weights(times(first:first + 3), t, w)
                else
                    call cardinal_weights((t - times(k))/(times(k + 1) - times(k)), w)
                end if
                series(i) = dot_product(w, old(first:first + 2*many - 1))
                noise = noise + sum(w**2)/n
            end associate
        end do
    end subroutine advance

    !> Leaves out the epochs of the accelerometer at which a series read at t + delay is more than an interval beyond an end.
    pure subroutine leave_out_beyond(delay, observations)
        real(dp), intent(in) :: delay           !! s
        type(observation_set_t), intent(inout) :: observations

        integer :: first, last, n

        n = size(observations%accelerometer_time)
        if (n < 4) return
        associate (t => observations%accelerometer_time)
            first = findloc(t + delay > 2*t(1) - t(2) - (t(2) - t(1))/2, .true., 1)
            last = findloc(t + delay < 2*t(n) - t(n - 1) + (t(n) - t(n - 1))/2, .true., 1, back=.true.)
        end associate
        if (first == 1 .and. last == n .or. first == 0 .or. last < first + 3) return
        observations%accelerometer_time = observations%accelerometer_time(first:last)
        observations%acceleration = observations%acceleration(:, first:last)
        if (allocated(observations%further_acceleration)) &
            observations%further_acceleration = observations%further_acceleration(:, first:last, :)
    end subroutine leave_out_beyond

    !> Whether as many samples up to the k-th and as many behind it are equally spaced.
    pure logical function is_even(times, k, many)
        real(dp), intent(in) :: times(:)
        integer, intent(in) :: k, many

        real(dp), parameter :: JITTER = 1e-3_dp     ! Of an interval

        associate (step => times(k + 1) - times(k), around => times(k - many + 1:k + many))
            is_even = all(abs(around(2:) - around(:2*many - 1) - step) < JITTER*step)
        end associate
    end function is_even

    !> Weights of the samples at four times for the value at t: Lagrange's, and beyond them those of the line through the
    !> outer two, which adds less noise.
    pure subroutine cubic_weights(times, t, weights)
        real(dp), intent(in) :: times(4), t
        real(dp), intent(out) :: weights(4)

        real(dp) :: beyond

        weights = 0
        if (t < times(1)) then
            beyond = (times(1) - t)/(times(2) - times(1))
            weights(:2) = [1 + beyond, -beyond]
        else if (t > times(4)) then
            beyond = (t - times(4))/(times(4) - times(3))
            weights(3:) = [-beyond, 1 + beyond]
        else
            weights = lagrange_weights(times, t)
        end if
    end subroutine cubic_weights

    !> Those of as many samples on both sides of a place between two, whose sum is 1.
    pure subroutine cardinal_weights(fraction, weights)
        real(dp), intent(in) :: fraction        !! Of an interval, behind the last sample of the first half
        real(dp), intent(out) :: weights(:)

        integer :: j, many

        many = size(weights)/2
        do j = 1, 2*many
            associate (x => PI*(fraction + many - j))
                weights(j) = sinc(x)*(1 + cos(x/many))/2
            end associate
        end do
        weights = weights/sum(weights)
    end subroutine cardinal_weights

    !> Makes an observation set as it is believed to be of one in which an alteration holds.
    pure subroutine apply_alteration(alteration, observations)
        integer, intent(in) :: alteration       !! Its place in ALTERATIONS
        type(observation_set_t), intent(inout) :: observations

        integer, parameter :: TO(3) = [2, 3, 1]
        integer :: i

        associate (k => observations%knowledge)
            select case (alteration)
            case (1:3)
                k%rods%gain(alteration) = -k%rods%gain(alteration)
            case (4)
                k%rods%gain = -k%rods%gain
            case (5:7)
                i = alteration - 4
                call interchange_rods(k%rods, i, TO(i))
            case (8:10)
                observations%acceleration(alteration - 7, :) = -observations%acceleration(alteration - 7, :)
                if (k%line%number > 1) observations%further_acceleration(alteration - 7, :, :) = &
                    -observations%further_acceleration(alteration - 7, :, :)
            case (11:13)
                i = alteration - 10
                observations%acceleration([i, TO(i)], :) = observations%acceleration([TO(i), i], :)
                if (k%line%number > 1) observations%further_acceleration([i, TO(i)], :, :) = &
                    observations%further_acceleration([TO(i), i], :, :)
            case (14:16)
                observations%field(alteration - 13, :) = -observations%field(alteration - 13, :)
            case (17:19)
                i = alteration - 16
                observations%field([i, TO(i)], :) = observations%field([TO(i), i], :)
            case (20)
                k%mounting = k%mounting(:, HEADS:1:-1)
            case (21)
                observations%quaternion(:3, :) = -observations%quaternion(:3, :)
            case (22)
                observations%quaternion = observations%quaternion([2, 3, 4, 1], :)
            case (23)
                observations%quaternion = observations%quaternion([2, 3, 4, 1], :)
                observations%quaternion(:3, :) = -observations%quaternion(:3, :)
            end select
        end associate
    end subroutine apply_alteration
end module gracecg_estimation_belief
