!> Samples that repeat: data that came twice, and a magnetometer or an accelerometer that is stuck.
module gracecg_estimation_repeated_samples
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t
    implicit none
    private
    public :: drop_repeated_samples, drop_stuck_samples

    real(dp), parameter :: LONGEST_STANDSTILL = 3.5_dp
    !! For which equal values in succession are passed, s. In the six cases of CSR-TM-00-01 the field in body
    !! axes changes by 10 nT and more every second.
    integer, parameter :: MOST_EQUAL = 20       !! Samples of an accelerometer's axis likewise; coarse steps of a converter repeat

contains

    !> Leaves the second of two samples of one time out, with a warning. Their values are alike in
    !> observations that check_observations has passed.
    subroutine drop_repeated_samples(observations, warnings)
        type(observation_set_t), intent(inout) :: observations
        type(string_t), allocatable, intent(inout) :: warnings(:)

        integer, allocatable :: kept(:)

        associate (set => observations)
            call find_kept('accelerometer', set%accelerometer_time, kept)
            set%accelerometer_time = set%accelerometer_time(kept)
            set%acceleration = set%acceleration(:, kept)
            if (allocated(set%angular_acceleration)) set%angular_acceleration = set%angular_acceleration(:, kept)
            call find_kept('magnetometer', set%magnetometer_time, kept)
            set%magnetometer_time = set%magnetometer_time(kept)
            set%field = set%field(:, kept)
            call find_kept('star camera', set%star_camera_time, kept, set%star_camera_head)
            set%star_camera_time = set%star_camera_time(kept)
            set%star_camera_head = set%star_camera_head(kept)
            set%quaternion = set%quaternion(:, kept)
            if (.not. allocated(set%orbit_time)) return
            call find_kept('orbit', set%orbit_time, kept)
            set%orbit_time = set%orbit_time(kept)
            set%orbit_position = set%orbit_position(:, kept)
        end associate

    contains

        !> The samples that come later than the one before them, of the same head if there are heads.
        subroutine find_kept(name, times, kept, heads_of)
            character(*), intent(in) :: name
            real(dp), intent(in) :: times(:)
            integer, allocatable, intent(out) :: kept(:)
            integer, intent(in), optional :: heads_of(:)

            real(dp) :: previous(HEADS)
            logical :: new(size(times))
            integer :: i, head

            previous = -huge(1.0_dp)
            head = 1
            do i = 1, size(times)
                if (present(heads_of)) head = heads_of(i)
                new(i) = times(i) > previous(head)
                previous(head) = times(i)
            end do
            kept = pack([(i, i=1, size(times))], new)
            if (all(new)) return
            call append(warnings, name//': repeated samples are left out: '// &
                        integer_text(count(.not. new))//', the first at '// &
                        number_text(times(findloc(new, .false., 1)))//' s')
        end subroutine find_kept
    end subroutine drop_repeated_samples

    !> Leaves out the samples of a magnetometer that keeps its last value, and of an accelerometer of which one axis does, all
    !> but the first, with a warning. A series that is constant from beginning to end is passed: whoever fits it refuses it.
    subroutine drop_stuck_samples(observations, warnings)
        type(observation_set_t), intent(inout) :: observations
        type(string_t), allocatable, intent(inout) :: warnings(:)

        logical :: stuck_field(size(observations%magnetometer_time)), stuck(size(observations%accelerometer_time))
        logical :: of_axis(size(stuck))
        integer, allocatable :: kept(:)
        integer :: axis, i

        associate (set => observations)
            stuck_field = standing_still(set%magnetometer_time, set%field, LONGEST_STANDSTILL)
            if (any(stuck_field) .and. count(stuck_field) < size(stuck_field) - 1) then
                call warn('magnetometer', set%magnetometer_time, stuck_field)
                kept = pack([(i, i=1, size(stuck_field))], .not. stuck_field)
                set%field = set%field(:, kept)
                set%magnetometer_time = set%magnetometer_time(kept)
            end if
            stuck = .false.
            do axis = 1, 3
                of_axis = standing_still(set%accelerometer_time, set%acceleration(axis:axis, :), &
                                         MOST_EQUAL*set%knowledge%accelerometer_interval)
                if (count(of_axis) < size(of_axis) - 1) stuck = stuck .or. of_axis
            end do
            if (.not. any(stuck)) return
            call warn('accelerometer', set%accelerometer_time, stuck)
            kept = pack([(i, i=1, size(stuck))], .not. stuck)
            set%acceleration = set%acceleration(:, kept)
            if (allocated(set%angular_acceleration)) set%angular_acceleration = set%angular_acceleration(:, kept)
            set%accelerometer_time = set%accelerometer_time(kept)
        end associate

    contains

        subroutine warn(name, times, left_out)
            character(*), intent(in) :: name
            real(dp), intent(in) :: times(:)
            logical, intent(in) :: left_out(:)

            call append(warnings, name//': stuck at one value: '//integer_text(count(left_out))// &
                        ' samples are left out, the first at '//number_text(times(findloc(left_out, .true., 1)))//' s')
        end subroutine warn
    end subroutine drop_stuck_samples

    !> Samples that repeat the one before them, of series in which that goes on for long.
    pure function standing_still(times, values, longest) result(stuck)
        real(dp), intent(in) :: times(:), values(:, :)
        real(dp), intent(in) :: longest         !! For which equal values are passed, s
        logical :: stuck(size(times))

        integer :: first, last

        stuck = .false.
        first = 1
        do while (first <= size(times))
            last = first
            do while (last < size(times))
                if (any(abs(values(:, last + 1) - values(:, first)) > 0)) exit
                last = last + 1
            end do
            if (times(last) - times(first) > longest) stuck(first + 1:last) = .true.
            first = last + 1
        end do
    end function standing_still
end module gracecg_estimation_repeated_samples
