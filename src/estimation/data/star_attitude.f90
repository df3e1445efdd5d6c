!> The attitude that the star camera delivers, in body axes, from the head that the setup names; where
!> it fails, from the other one.
module gracecg_estimation_star_attitude
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: number_text
    use gracecg_base_statistics, only: order_of
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, normalised
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_interpolation, only: is_covered, LONGEST_GAP, REACH
    implicit none
    private
    public :: star_attitude_t, take_star_attitude

    integer, parameter :: MOST_PAIRS = 50       !! Pairs of samples that tell how far heads are apart

    !> The attitude as the star camera saw it, ready for interpolation.
    type :: star_attitude_t
        real(dp), allocatable :: time(:)            !! (samples), increasing, s
        integer, allocatable :: head(:)             !! (samples)
        real(dp), allocatable :: quaternion(:, :)   !! (4, samples), inertial to body, free of flips
        integer :: pairs = 0                        !! Samples of both heads at one time
        real(dp) :: head_turn(3) = 0                !! From head 1 to head 2, their mean, body axes, rad
    end type star_attitude_t

contains

    !> Steps 1 and 2 of CSR-TM-00-01 section 4.5: quaternions turned to body axes (4-33), freed of sign flips
    !> and normalised (4-37). The other head's samples are taken where the used head leaves a gap that
    !> interpolation does not bridge. Warns of the change of head and of what gap remains.
    subroutine take_star_attitude(observations, like, stars, warnings)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: like(4)     !! A quaternion whose sign the first sample gets
        type(star_attitude_t), intent(out) :: stars
        type(string_t), allocatable, intent(inout) :: warnings(:)

        real(dp) :: q(4), neighbour(4)
        integer, allocatable :: order(:)
        integer :: i

        order = chosen_samples(observations)
        stars%time = observations%star_camera_time(order)
        stars%head = observations%star_camera_head(order)
        allocate (stars%quaternion(4, size(order)))
        neighbour = like
        do i = 1, size(order)
            q = in_body_axes(observations, order(i))
            ! q and -q are one attitude: keep the sign of the neighbour
            if (dot_product(q, neighbour) < 0) q = -q
            stars%quaternion(:, i) = q
            neighbour = q
        end do
        call compare_heads(observations, stars%head_turn, stars%pairs)
        call warn_of_other_head(observations%knowledge%camera, stars, warnings)
        if (size(order) > 0) call warn_of_gaps(stars%time, observations%knowledge%star_camera_interval, &
                                               observations%knowledge%duration, warnings)
    end subroutine take_star_attitude

    !> The mean turn from the attitude that head 1 shows to that of head 2, about body axes, over samples of one time; none
    !> where the heads have no common times.
    pure subroutine compare_heads(observations, turn, compared)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(out) :: turn(3)        !! Rotation vector, rad
        integer, intent(out) :: compared        !! Pairs of samples

        integer, allocatable :: of_head_1(:), of_head_2(:)
        real(dp) :: relative(4)
        integer :: i, k

        turn = 0
        compared = 0
        associate (head => observations%star_camera_head, time => observations%star_camera_time)
            of_head_1 = pack([(i, i=1, size(head))], head == 1)
            of_head_2 = pack([(i, i=1, size(head))], head == 2)
            do i = 1, size(of_head_1)
                k = findloc(abs(time(of_head_2) - time(of_head_1(i))) <= 0, .true., 1)
                if (k == 0) cycle
                relative = quaternion_product(in_body_axes(observations, of_head_2(k)), &
                                              conjugate_quaternion(in_body_axes(observations, of_head_1(i))))
                turn = turn + 2*relative(:3)*sign(1.0_dp, relative(4))
                compared = compared + 1
                if (compared == MOST_PAIRS) exit
            end do
        end associate
        turn = turn/max(1, compared)
    end subroutine compare_heads

    !> The attitude of a sample, turned to body axes (4-33) and normalised.
    pure function in_body_axes(observations, i) result(q)
        type(observation_set_t), intent(in) :: observations
        integer, intent(in) :: i                !! Which sample
        real(dp) :: q(4)                        !! Inertial to body

        associate (mounting => observations%knowledge%mounting(:, observations%star_camera_head(i)))
            q = normalised(quaternion_product(conjugate_quaternion(mounting), observations%quaternion(:, i)))
        end associate
    end function in_body_axes

    !> The samples to use, in the order of time: those of the used head, and those of the other one
    !> that interpolation between the first would not reach.
    pure function chosen_samples(observations) result(order)
        type(observation_set_t), intent(in) :: observations
        integer, allocatable :: order(:)

        integer, allocatable :: used(:), other(:)
        real(dp), allocatable :: used_times(:)
        integer :: i

        associate (times => observations%star_camera_time, head => observations%star_camera_head, &
                   knowledge => observations%knowledge)
            used = pack([(i, i=1, size(times))], head == knowledge%camera .or. knowledge%camera == 0)
            other = pack([(i, i=1, size(times))], .not. (head == knowledge%camera .or. knowledge%camera == 0))
            used_times = times(used)
            other = pack(other, [(.not. is_covered(used_times, times(other(i)), knowledge%star_camera_interval), &
                                  i=1, size(other))])
            order = [used, other]
            order = order(order_of(times(order)))
        end associate
    end function chosen_samples

    subroutine warn_of_other_head(camera, stars, warnings)
        integer, intent(in) :: camera       !! The head that the setup names
        type(star_attitude_t), intent(in) :: stars
        type(string_t), allocatable, intent(inout) :: warnings(:)

        integer :: first, last

        if (camera == 0) return
        first = 1
        do while (first <= size(stars%head))
            last = first
            if (stars%head(first) /= camera) then
                do while (last < size(stars%head))
                    if (stars%head(last + 1) == camera) exit
                    last = last + 1
                end do
                call append(warnings, 'star camera: head '//integer_text(HEADS + 1 - camera)// &
                            ' stands in for head '//integer_text(camera)//' from '// &
                            number_text(stars%time(first))//' s to '//number_text(stars%time(last))//' s')
            end if
            first = last + 1
        end do
    end subroutine warn_of_other_head

    subroutine warn_of_gaps(times, interval, duration, warnings)
        real(dp), intent(in) :: times(:)        !! s
        real(dp), intent(in) :: interval        !! Sampling interval, s
        real(dp), intent(in) :: duration        !! Of the arc, s
        type(string_t), allocatable, intent(inout) :: warnings(:)

        integer :: i, n

        n = size(times)
        if (times(1) > (1 + REACH)*interval) call warn(0.0_dp, times(1))
        do i = 1, n - 1
            if (times(i + 1) - times(i) > LONGEST_GAP*interval) call warn(times(i), times(i + 1))
        end do
        if (times(n) < duration - REACH*interval) call warn(times(n), duration)

    contains

        subroutine warn(from, to)
            real(dp), intent(in) :: from, to

            call append(warnings, 'star camera: no samples from '//number_text(from)//' s to '// &
                        number_text(to)//' s; the attitude there is left out')
        end subroutine warn
    end subroutine warn_of_gaps
end module gracecg_estimation_star_attitude
