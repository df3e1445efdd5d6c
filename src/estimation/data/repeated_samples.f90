!> Samples that repeat: data that came twice, and a magnetometer that is stuck.
module gracecg_estimation_repeated_samples
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t
    implicit none
    private
    public :: drop_repeated_samples, drop_stuck_field

    real(dp), parameter :: LONGEST_STANDSTILL = 3.5_dp
    !! For which equal values in succession are passed, s. In the six cases of CSR-TM-00-01 the field in body
    !! axes changes by 10 nT and more every second.

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

    !> Leaves out the samples of a magnetometer that keeps its last value, all but the first, with a warning.
    !> A series that is constant from beginning to end is passed: it is no measurement in orbit.
    subroutine drop_stuck_field(observations, warnings)
        type(observation_set_t), intent(inout) :: observations
        type(string_t), allocatable, intent(inout) :: warnings(:)

        logical :: stuck(size(observations%magnetometer_time))
        integer :: first, last, n

        n = size(stuck)
        stuck = .false.
        first = 1
        do while (first <= n)
            last = first
            do while (last < n)
                if (any(abs(observations%field(:, last + 1) - observations%field(:, first)) > 0)) exit
                last = last + 1
            end do
            associate (times => observations%magnetometer_time)
                if (times(last) - times(first) > LONGEST_STANDSTILL) stuck(first + 1:last) = .true.
            end associate
            first = last + 1
        end do
        if (count(stuck) == 0 .or. count(stuck) == n - 1) return
        associate (times => observations%magnetometer_time)
            call append(warnings, 'magnetometer: stuck at one value: '//integer_text(count(stuck))// &
                        ' samples are left out, the first at '//number_text(times(findloc(stuck, .true., 1)))//' s')
            observations%field = reshape(pack(observations%field, spread(.not. stuck, 1, 3)), [3, count(.not. stuck)])
            observations%magnetometer_time = pack(times, .not. stuck)
        end associate
    end subroutine drop_stuck_field
end module gracecg_estimation_repeated_samples
