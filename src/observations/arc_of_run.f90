!> Parts of an observation set: an arc of a long run with a time 0 of its own.
module gracecg_observations_arc_of_run
    use gracecg_base_kinds, only: dp
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_environment_time, only: utc_plus, tai_minus_utc, sidereal_angle
    use gracecg_spacecraft_moment_series, only: moment_series_t
    use gracecg_spacecraft_torque_rods, only: begin_rods_at
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    implicit none
    private
    public :: arc_of_run, without_moments

    real(dp), parameter :: ROUNDING = 1e-6_dp       !! Of a sampling interval
    integer, parameter :: FIELD_MARGIN = 3, ORBIT_MARGIN = 4
    !! Samples of magnetometer and orbit beyond the ends of an arc, for interpolation

contains

    !> The arc behind `from`, up to and with `to`: the samples in it, each in one of several arcs that follow each
    !> other, and beyond its ends those of magnetometer, orbit and rods that interpolation reaches. Its time 0 is
    !> `from`, and all times count from there: time tags, the rods' manoeuvre and its measured moments, the angle of
    !> the Earth. What is known of torque that changes over the run is shared out by length. The angular velocity at
    !> the run's time 0 is known to an arc that begins there alone.
    !>
    !> The run's knowledge is handed over beside, without the measured moments, which may be many: an arc is cut in a
    !> time that is its own length's.
    pure subroutine arc_of_run(observations, knowledge, from, to, arc)
        type(observation_set_t), intent(in) :: observations     !! That pass check_observations
        type(operator_knowledge_t), intent(in) :: knowledge     !! Theirs; its measured moments are not looked at
        real(dp), intent(in) :: from, to                        !! s, from < to
        type(observation_set_t), intent(out) :: arc

        real(dp) :: slack, margin
        integer :: first, last

        arc%knowledge = knowledge_of_arc(knowledge, from, to - from)
        call begin_rods_at(observations%knowledge%rods%measured, from, to - from, arc%knowledge%rods)
        slack = ROUNDING*knowledge%accelerometer_interval
        associate (time => observations%accelerometer_time)
            first = last_not_after(time, from + slack) + 1
            last = last_not_after(time, to + slack)
            call take(time, observations%acceleration, first, last, from, arc%accelerometer_time, arc%acceleration)
        end associate
        if (allocated(observations%further_acceleration)) &
            arc%further_acceleration = observations%further_acceleration(:, first:last, :)
        associate (time => observations%star_camera_time)
            call take_stars(observations, time > from + slack .and. time <= to + slack, from, arc)
        end associate
        margin = FIELD_MARGIN*knowledge%magnetometer_interval
        associate (time => observations%magnetometer_time)
            call take(time, observations%field, last_not_after(time, from - margin) + 1, &
                      last_not_after(time, to + margin), from, arc%magnetometer_time, arc%field)
        end associate
        if (.not. has_orbit(observations)) return
        associate (time => observations%orbit_time)
            call take(time, observations%orbit_position, max(1, last_not_after(time, from) - ORBIT_MARGIN), &
                      min(size(time), last_not_after(time, to) + ORBIT_MARGIN), from, arc%orbit_time, arc%orbit_position)
        end associate
    end subroutine arc_of_run

    !> The same knowledge but for the measured moments of the rods.
    pure function without_moments(knowledge) result(rest)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(operator_knowledge_t) :: rest

        rest = knowledge
        rest%rods%measured = moment_series_t()
    end function without_moments

    !> What an operator knows, at a later time 0 and for an arc that begins there.
    pure function knowledge_of_arc(knowledge, from, duration) result(moved)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: from, duration      !! s
        type(operator_knowledge_t) :: moved

        moved = knowledge
        moved%epoch = utc_plus(knowledge%epoch, from)
        moved%duration = duration
        moved%torque_change = knowledge%torque_change*(duration/knowledge%duration)
        moved%sidereal_angle = sidereal_angle(knowledge%sidereal_angle, from)
        ! UT1 - TAI hardly changes: UT1 - UTC jumps with a leap second
        moved%earth_parameters%ut1_minus_utc = knowledge%earth_parameters%ut1_minus_utc + &
            (tai_minus_utc(moved%epoch) - tai_minus_utc(knowledge%epoch))
        if (.not. from > 0) return
        moved%angular_velocity = 0
        moved%angular_velocity_sigma = 0
    end function knowledge_of_arc

    !> The samples of a series from one number to another.
    pure subroutine take(time, values, first, last, from, part_time, part_values)
        real(dp), intent(in) :: time(:), values(:, :)
        integer, intent(in) :: first, last
        real(dp), intent(in) :: from        !! The part's time 0, s
        real(dp), allocatable, intent(inout) :: part_time(:), part_values(:, :)

        part_time = time(first:last) - from
        part_values = values(:, first:last)
    end subroutine take

    !> Both heads' samples stand in one series, not always in the order of time.
    pure subroutine take_stars(observations, wanted, from, part)
        type(observation_set_t), intent(in) :: observations
        logical, intent(in) :: wanted(:)
        real(dp), intent(in) :: from        !! The part's time 0, s
        type(observation_set_t), intent(inout) :: part

        integer, allocatable :: places(:)
        integer :: i

        places = pack([(i, i=1, size(wanted))], wanted)
        part%star_camera_time = observations%star_camera_time(places) - from
        part%star_camera_head = observations%star_camera_head(places)
        part%quaternion = observations%quaternion(:, places)
    end subroutine take_stars
end module gracecg_observations_arc_of_run
