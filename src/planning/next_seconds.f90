!> What the rods should do in the next seconds, of a calibration that goes on until its offset is known: of the manoeuvres of
!> the structured search (gracecg_planning_candidates) that which makes the worst axis of the offset best, with all that is
!> known already, and keeps the limits of rods, rate and pointing.
!>
!> What a manoeuvre adds is its information about d with a bias and a drift of its own in these seconds
!> (gracecg_estimation_offset_information). That is less than it will be worth, since bias and drift go on. The field is taken
!> to stay as it is.
module gracecg_planning_next_seconds
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moments, TAPERED
    use gracecg_simulation_dynamics, only: RATE => OMEGA
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_offset_information, only: gather_information
    use gracecg_planning_candidates, only: design_settings_t, candidate_t, check_design_settings, structured_candidates, rods_of
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, thin_arc, fly_moments
    implicit none
    private
    public :: next_seconds_t, begin_planning

    real(dp), parameter :: TAPER = 1            !! Of the rods' moments, so that plans follow each other without a jump, s
    real(dp), parameter :: STEPS_OF_PERIOD = 12     !! Epochs at which a manoeuvre is judged, of its shortest period

    !> A planner: the manoeuvres that it chooses from, and where it judges them.
    type :: next_seconds_t
        type(planned_arc_t) :: arc                  !! The seconds, thinned
        type(manoeuvre_site_t) :: site              !! Field and rate of the last plan
        type(design_settings_t) :: settings         !! Of the manoeuvres
        type(candidate_t), allocatable :: candidates(:)     !! The manoeuvres
        real(dp), allocatable :: dipole(:, :, :)    !! (3, 0:2n, candidate), A m^2
    contains
        procedure :: plan       !! Chooses one
    end type next_seconds_t

contains

    !> Lays out tapered sines of whole cycles. Fails when the noise is not given, or when no manoeuvre is allowed.
    subroutine begin_planning(knowledge, seconds, amplitude, self, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: seconds             !! That are planned at once
        real(dp), intent(in) :: amplitude           !! Of a rod, A m^2
        type(next_seconds_t), intent(out) :: self
        type(error_t), allocatable, intent(out) :: error

        type(planned_arc_t) :: all_samples
        integer :: i, n

        self%settings%amplitude = amplitude
        self%settings%waveform_used = .false.
        self%settings%waveform_used(TAPERED) = .true.
        self%settings%taper = TAPER
        self%settings%lowest_frequency = max(self%settings%lowest_frequency, 1/seconds)
        all_samples%knowledge = knowledge
        all_samples%interval = knowledge%accelerometer_interval
        all_samples%samples = nint(seconds/all_samples%interval)
        call check_design_settings(all_samples, self%settings, error)
        n = min(all_samples%samples, ceiling(STEPS_OF_PERIOD*seconds*self%settings%highest_frequency))
        if (.not. allocated(error)) call thin_arc(all_samples, n, self%arc, error)
        if (allocated(error)) return
        self%candidates = structured_candidates(self%arc, self%settings)
        allocate (self%site%field(3, 0:2*n), self%dipole(3, 0:2*n, size(self%candidates)))
        do i = 1, size(self%candidates)
            call dipole_moments(rods_of(self%settings, seconds, self%candidates(i)), self%arc%interval/2, self%dipole(:, :, i))
        end do
    end subroutine begin_planning

    !> Chooses the manoeuvre of the next seconds. Where none keeps the limits the rods rest: then there are no activations.
    pure subroutine plan(self, covariance, field, turn, angular_velocity, held_rate, rods, sigma)
        class(next_seconds_t), intent(inout) :: self
        real(dp), intent(in) :: covariance(3, 3)        !! Of the offset, so far, m^2
        real(dp), intent(in) :: field(3)                !! Body axes, T
        real(dp), intent(in) :: turn(3)                 !! From the attitude that is held to the true one, body axes, rad
        real(dp), intent(in) :: angular_velocity(3)     !! Body axes, rad/s
        real(dp), intent(in) :: held_rate(3)            !! Of the attitude that is held, body axes, rad/s
        type(torque_rods_t), intent(out) :: rods        !! Times count from now
        real(dp), intent(out) :: sigma(3)               !! What is expected then, m

        real(dp), dimension(3, self%arc%samples) :: omega, omega_dot, theta
        real(dp) :: known(3, 3), information(3, 3), after(3, 3), least, excursion, t
        type(attitude_motion_t) :: motion
        integer :: i, k, best

        sigma = [(sqrt(covariance(k, k)), k=1, 3)]
        if (.not. allocated(self%candidates)) return        ! it has not begun: nothing to choose from
        known = inverse_3x3(covariance)
        self%site%state(RATE) = angular_velocity
        self%site%field = spread(field, 2, size(self%site%field, 2))
        least = maxval(sigma)**2
        best = 0
        do i = 1, size(self%candidates)
            call fly_moments(self%arc, self%site, self%dipole(:, :, i), omega, omega_dot, theta, motion)
            excursion = 0
            do k = 1, self%arc%samples
                t = k*self%arc%interval
                excursion = max(excursion, norm2(theta(:, k) + turn + t*(angular_velocity - held_rate)))
            end do
            if (.not. (motion%rate <= self%arc%knowledge%limits%rate .and. &
                       excursion <= self%arc%knowledge%limits%pointing)) cycle
            call gather_information(omega, omega_dot, self%arc%whiteners, information)
            after = inverse_3x3(known + information)
            if (.not. max(after(1, 1), after(2, 2), after(3, 3)) < least) cycle
            best = i
            least = max(after(1, 1), after(2, 2), after(3, 3))
            sigma = [(sqrt(after(k, k)), k=1, 3)]
        end do
        if (best > 0) rods = rods_of(self%settings, self%arc%duration(), self%candidates(best))
        rods%largest_moment = self%arc%knowledge%rods%largest_moment
    end subroutine plan
end module gracecg_planning_next_seconds
