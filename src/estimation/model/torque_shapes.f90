!> What rods and magnetic field that are not as believed do to the torque, and the moments that leak into the accelerometer.
module gracecg_estimation_torque_shapes
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_moments, rod_direction, interchange_rods, gain_unit, torque_of
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_model_state, only: physical_model_t, turned_about
    implicit none
    private
    public :: take_torque_shapes, take_moments

contains

    !> What rods and magnetic field that are not as believed would do to the torque m x B.
    subroutine take_torque_shapes(knowledge, data, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        type(physical_model_t), intent(inout) :: model

        real(dp), parameter :: TURN_STEP = 1e-6_dp, FREQUENCY_STEP = 1e-7_dp    ! rad, Hz
        type(torque_rods_t) :: rods, other
        real(dp), dimension(3, 0:2*model%steps) :: along, up, down
        real(dp) :: direction(3)
        integer :: i, k

        rods = knowledge%rods
        rods%delay = rods%delay + knowledge%accelerometer_delay
        if (asked(ROD_GAINS(1))) then
            other = rods
            other%gain = gain_unit(rods%gain)
            call follow(other, along)
            do i = 1, 3
                call add(along(i, :), rod_direction(rods, i), ROD_GAINS(i))
            end do
        end if
        if (asked(ROD_DELAYS(1)) .or. asked(ALL_RODS_DELAY)) then
            ! steps of the spacing of the torque: a jump at an abrupt edge then falls on two places, whose weights in the
            ! Runge-Kutta steps are those of a step wherever they lie
            other = rods
            other%delay = rods%delay + model%interval/2
            call follow(other, up)
            other%delay = rods%delay - model%interval/2
            call follow(other, down)
            call add_to_each_and_all((up - down)/model%interval, ROD_DELAYS, ALL_RODS_DELAY)
        end if
        if (asked(ROD_FREQUENCIES(1)) .or. asked(ALL_RODS_FREQUENCY)) then
            other = rods
            other%activations%frequency = rods%activations%frequency + FREQUENCY_STEP
            call follow(other, up)
            other%activations%frequency = rods%activations%frequency - FREQUENCY_STEP
            call follow(other, down)
            call add_to_each_and_all((up - down)/(2*FREQUENCY_STEP), ROD_FREQUENCIES, ALL_RODS_FREQUENCY)
        end if
        if (asked(ROD_TURNS(1)) .or. asked(ROD_SWAPS(1))) call follow(rods, along)
        do i = 1, merge(size(ROD_TURNS), 0, asked(ROD_TURNS(1)))
            k = (i + 1)/2
            other = rods
            other%misalignment(i) = rods%misalignment(i) + TURN_STEP
            direction = rod_direction(other, k)
            other%misalignment(i) = rods%misalignment(i) - TURN_STEP
            call add(along(k, :), (direction - rod_direction(other, k))/(2*TURN_STEP), ROD_TURNS(i))
        end do
        do i = 1, merge(3, 0, asked(ROD_SWAPS(1)))
            other = rods
            call interchange_rods(other, i, modulo(i, 3) + 1)
            call follow(other, up)
            do k = 1, 3
                call add(up(k, :) - along(k, :), rod_direction(rods, k), ROD_SWAPS(i))
            end do
        end do
        do i = 1, size(model%shaped)
            if (IS_OF_FIELD(model%shaped(i))) call take_field_shape(data, model, i)
            if (any(TORQUE_BENDS == model%shaped(i))) call take_bent_torque(model, i)
        end do

    contains

        !> Are parameters of a kind among those asked for?
        logical function asked(kind)
            integer, intent(in) :: kind

            asked = any(KIND_OF(model%shaped) == kind)
        end function asked

        !> The moments of the rods along themselves at the times of the torque.
        subroutine follow(some, moments)
            type(torque_rods_t), intent(in) :: some
            real(dp), intent(out) :: moments(3, 0:2*model%steps)

            integer :: j

            do j = 0, 2*model%steps
                moments(:, j) = rod_moments(some, j*model%interval/2)
            end do
        end subroutine follow

        !> Adds the torque of changes of the moments to the parameter of each rod and to that of all.
        subroutine add_to_each_and_all(change, of_each, of_all)
            real(dp), intent(in) :: change(3, 0:2*model%steps)
            integer, intent(in) :: of_each(3), of_all

            integer :: rod

            do rod = 1, 3
                call add(change(rod, :), rod_direction(rods, rod), of_each(rod))
                call add(change(rod, :), rod_direction(rods, rod), of_all)
            end do
        end subroutine add_to_each_and_all

        !> Adds the torque of a moment of one direction to the shape of a parameter, if that is asked for.
        subroutine add(moment, direction_of, parameter)
            real(dp), intent(in) :: moment(0:2*model%steps), direction_of(3)
            integer, intent(in) :: parameter

            integer :: j, place

            place = findloc(model%shaped, parameter, 1)
            if (place == 0) return
            do j = 0, 2*model%steps
                model%shape(:, j, place) = model%shape(:, j, place) + moment(j)*torque_of(rods, direction_of, data%field(:, j + 1))
            end do
        end subroutine add
    end subroutine take_torque_shapes

    !> A torque along Legendre's polynomial of degree 2 or 3 over the arc.
    pure subroutine take_bent_torque(model, place)
        type(physical_model_t), intent(inout) :: model
        integer, intent(in) :: place            ! Among model%shaped

        real(dp) :: x
        integer :: axis, j

        axis = (MEMBER_OF(model%shaped(place)) + 1)/2
        do j = 0, 2*model%steps
            x = real(j, dp)/model%steps - 1
            model%shape(axis, j, place) = merge((3*x**2 - 1)/2, (5*x**3 - 3*x)/2, mod(MEMBER_OF(model%shaped(place)), 2) == 1)
        end do
    end subroutine take_bent_torque

    !> The moments of the rods where their leakage is asked for, and their rates, over a sample or RATE_OVER, whichever is less;
    !> of moments that are held the torque that samples show beside that of the integration.
    subroutine take_moments(knowledge, data, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        type(physical_model_t), intent(inout) :: model

        real(dp), parameter :: RATE_OVER = 0.1_dp   ! s: of 1 Hz 1.6 % of its rate is lost; over the second of means, of 0.1 Hz
        type(torque_rods_t) :: rods, leaking
        real(dp) :: jumps(3)
        integer :: k, n, rod

        n = -1
        if (any(is_leakage(model%estimated))) n = model%steps
        allocate (model%moment(3, 0:n), model%moment_rate(3, 0:n))
        rods = knowledge%rods
        rods%delay = rods%delay + knowledge%accelerometer_delay
        leaking = rods
        leaking%gain = 1            ! by the moments that are commanded or measured
        do k = 0, n
            associate (t => k*model%interval, half => min(model%interval, RATE_OVER)/2)
                model%moment(:, k) = rod_moments(leaking, t, .true.)
                model%moment_rate(:, k) = (rod_moments(leaking, t + half, .true.) - rod_moments(leaking, t - half, .true.))/ &
                    (2*half)
            end associate
        end do
        n = -1
        if (rods%measured%held) n = model%steps
        allocate (model%jump_torque(3, 3, 0:n))
        do k = 0, n
            jumps = rod_moments(rods, k*model%interval, .true.) - rod_moments(rods, k*model%interval)
            do rod = 1, 3
                model%jump_torque(:, rod, k) = jumps(rod)*torque_of(rods, rod_direction(rods, rod), data%field(:, 2*k + 1))
            end do
        end do
    end subroutine take_moments

    !> Does a parameter act by the moments of the rods beside their torque?
    elemental logical function is_leakage(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_leakage = any(KIND_OF(parameter) == [LEAKAGE(1), LEAKAGE_RATE(1), CHANNEL_LEAKAGE(1), CHANNEL_LEAKAGE_RATE(1)])
    end function is_leakage

    !> The torque by a change of the field by 1 of a parameter, m x dB/dp. Samples that are tagged late show the field of an
    !> earlier time: that at t stands at t + delay.
    pure subroutine take_field_shape(data, model, place)
        type(fitting_data_t), intent(in) :: data
        type(physical_model_t), intent(inout) :: model
        integer, intent(in) :: place            ! Among model%shaped

        real(dp) :: change(3)
        integer :: i, next, before, after, j

        i = MEMBER_OF(model%shaped(place))
        next = modulo(i, 3) + 1
        do j = 0, 2*model%steps
            change = 0
            associate (b => data%field(:, j + 1))
                select case (KIND_OF(model%shaped(place)))
                case (FIELD_TURN(1))
                    change = turned_about(i, b)
                case (FIELD_SCALES(1))
                    change(i) = -b(i)
                case (FIELD_SHEARS(1))
                    change([i, next]) = -b([next, i])
                case (FIELD_SWAPS(1))
                    change([i, next]) = b([next, i]) - b([i, next])
                case (FIELD_DELAY)
                    before = max(0, j - 1)
                    after = min(2*model%steps, j + 1)
                    change = (data%field(:, after + 1) - data%field(:, before + 1))/((after - before)*model%interval/2)
                end select
            end associate
            model%shape(:, j, place) = cross(model%dipole(:, j), change)
        end do
    end subroutine take_field_shape
end module gracecg_estimation_torque_shapes
