!> The C interface: the estimate while a manoeuvre goes on. Documented in include/gracecg.h.
module gracecg_interface_live
    use gracecg, only: dp, error_t, live_estimate_t, live_sample_t, begin_live_estimate
    use gracecg_base_text, only: integer_text
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_items, only: items_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    use gracecg_interface_observations, only: setup_object_t
    implicit none
    private
    public :: live_object_t, live_begin, live_add

    !> An estimate that goes on behind a handle: of one thread at a time.
    type, extends(object_t) :: live_object_t
        type(live_estimate_t) :: estimate               !! What has been told so far
    contains
        procedure :: tell => tell_live                  !! Puts its items
    end type live_object_t

contains

    !> Begins with what an operator knows, a guess of attitude and angular velocity, and the frequency of a density wave.
    subroutine live_begin(setup, quaternion, angular_velocity, wave_frequency, made, outcome)
        class(setup_object_t), intent(in) :: setup
        real(dp), intent(in) :: quaternion(4)           !! At the first sample, inertial to body
        real(dp), intent(in) :: angular_velocity(3)     !! The same, body axes, rad/s
        real(dp), intent(in) :: wave_frequency          !! Hz; 0: no wave
        type(live_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call begin_live_estimate(setup%knowledge, quaternion, angular_velocity, made%estimate, failure, wave_frequency)
        call outcome%take(failure)
    end subroutine live_begin

    !> Adds what has come in the next sampling interval, at its end.
    subroutine live_add(live, time, moment, accelerations, acceleration, fields, flux_density, positions, position, stars, &
                        star_time, star_head, quaternion, outcome)
        class(live_object_t), intent(inout) :: live
        real(dp), intent(in) :: time                            !! Of the end, s
        real(dp), intent(in) :: moment(3, 3)                    !! At beginning, middle, end; body axes, A m^2
        integer, intent(in) :: accelerations, fields, positions, stars      !! How many of each have come
        real(dp), intent(in), optional :: acceleration(3, accelerations)    !! Body axes, m/s^2
        real(dp), intent(in), optional :: flux_density(3, fields)           !! Body axes, T
        real(dp), intent(in), optional :: position(3, positions)            !! Inertial, m
        real(dp), intent(in), optional :: star_time(stars)                  !! s
        integer, intent(in), optional :: star_head(stars)                   !! 1 or 2
        real(dp), intent(in), optional :: quaternion(4, stars)              !! Inertial to camera
        type(outcome_t), intent(inout) :: outcome

        type(live_sample_t) :: sample
        type(error_t), allocatable :: failure
        integer :: i

        sample%time = time
        sample%moment = moment
        sample%has_acceleration = accelerations > 0
        if (accelerations > 0) sample%acceleration = acceleration(:, 1)
        sample%has_field = fields > 0
        if (fields > 0) sample%field = flux_density(:, 1)
        if (positions > 0) sample%position = position(:, 1)
        do i = 1, stars
            associate (head => star_head(i))
                if (head < 1 .or. head > HEADS .or. count(star_head == head) > 1) then
                    call outcome%refuse(STATUS_BAD_VALUE, 'star_head '//integer_text(i)//' = '//integer_text(head)// &
                                        ' is not 1 or 2, or it is given twice')
                    return
                end if
                sample%has_attitude(head) = .true.
                sample%attitude_time(head) = star_time(i)
                sample%quaternion(:, head) = quaternion(:, i)
            end associate
        end do
        call live%estimate%add(sample, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine live_add

    subroutine tell_live(self, items)
        class(live_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        real(dp) :: offset(3), covariance(3, 3), variance
        integer :: i

        call self%estimate%now(offset, covariance, variance)
        call items%put('offset', offset)
        call items%put('sigma', [(sqrt(covariance(i, i)), i=1, 3)])
        call items%put('covariance', covariance)
        call items%put('variance_factor', variance)
        call items%put('time', self%estimate%time)
        call items%put('counts', real([self%estimate%samples, self%estimate%edited], dp))
        call items%put('wave', self%estimate%wave())
    end subroutine tell_live
end module gracecg_interface_live
