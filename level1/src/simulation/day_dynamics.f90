!> The dynamics of a day with calibration manoeuvres: what currents, thrusters and a controller do to a satellite beside
!> all that gracecg_simulation_dynamics has.
!>
!> In a span the currents are those of the manoeuvre, else slow ones of science mode and, where wanted, tones that go on all
!> day (a whisper). Between the spans a controller keeps the satellite near the attitude that is held
!> (gracecg_simulation_attitude_control): by a torque as it is wanted, or by currents and thrusters. It lets go, smoothly, well
!> before each span and takes over well after it. Thrusters fire in pairs.
module gracecg_level1_day_dynamics
    use gracecg_level1_basics
    use gracecg_base_constants, only: PI
    use gracecg_base_vectors, only: transformed, transformed_back
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, loads_t, POSITION, ATTITUDE, STATE_SIZE
    use gracecg_level1_simulation_settings, only: level1_settings_t, level1_span_settings_t
    implicit none
    private
    public :: day_dynamics_t, firing_t, PAIRS

    !> Pairs of thrusters that fire together (numbers of on_time), and their torques: GRACEiolib.h, after SDSPSD v3.0
    integer, parameter :: PAIRS(2, 4) = reshape([1, 7, 3, 9, 5, 11, 6, 12], [2, 4])
    !> Two forces of THRUSTER along +-y, at 1.45 m along x or 0.30 m along z: yaw and roll, N m
    real(dp), parameter :: TORQUES(3, 4) = reshape([0.0_dp, 0.0_dp, -0.029_dp, 0.0_dp, 0.0_dp, 0.029_dp, &
                                                    -0.006_dp, 0.0_dp, 0.0_dp, 0.006_dp, 0.0_dp, 0.0_dp], [3, 4])
    real(dp), parameter :: THRUSTER = 0.010_dp          ! of one thruster, N: likewise
    real(dp), parameter :: FIRING_TIME = 0.05_dp        ! s: THR1A of GRACE-FO C, 2023-06-01
    real(dp), parameter :: FREE = 25, TAKE_OVER = 60
    ! The controller rests so long around a span, and so long takes it to act fully, s: its torque changes slowly beside the
    ! rods' lines (12 s and less), and what an estimate takes beyond the ends of a span is free of it. Spans are 120 s apart
    real(dp), parameter :: SLOWEST(2) = [1500.0_dp, 470.0_dp]
    ! Periods of currents in science mode, s: a quarter of a revolution, as a rod follows the field, and a third of that; chosen,
    ! as their PARTS of the largest current are: of the slow one, the quick one and a constant one
    real(dp), parameter :: PARTS(3) = [0.5_dp, 0.3_dp, 0.2_dp]

    type :: firing_t
        !! One firing of a pair of thrusters
        real(dp) :: time = 0        !! When it begins, s
        integer :: pair = 1         !! Of PAIRS
        real(dp) :: mismatch = 0    !! Force left over along y, of that of one thruster
    end type firing_t

    type, extends(satellite_dynamics_t) :: day_dynamics_t
        !! Times are GPS, s from the beginning of the files
        type(level1_span_settings_t), allocatable :: spans(:)   !! The sub-manoeuvres
        type(level1_settings_t) :: settings !! What is flown
        real(dp) :: tag = 0, tag_interval = 0.5_dp      !! One tag of the currents, and from tag to tag, s
        real(dp) :: gain(3) = 0             !! kappa of the rods, A m^2/mA
        real(dp) :: science(3, 3) = 0       !! Two phases and a mean, parts of 1, by rod
        type(firing_t), allocatable :: firings(:)       !! In order of time
        real(dp) :: window = 0
        !! Of which firings take a share: that of a sample of the accelerometer, s; 0: an instant
    contains
        procedure :: actuate                !! Torques of rods, thrusters, controller
        procedure :: next_edge              !! When one of them jumps next
        procedure :: thrust                 !! Force that thrusters leave over
        procedure :: flowing_current        !! The currents that flow at a time
        procedure :: tagged_current         !! The currents that a tag names, but for the controller's
        procedure :: control_current        !! The controller's
    end type day_dynamics_t

contains

    !> The torques of rods and thrusters, and that of the controller with the latter's.
    pure subroutine actuate(self, t, y, acting)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t                   !! s
        real(dp), intent(in) :: y(STATE_SIZE)       !! State
        type(loads_t), intent(inout) :: acting      !! With the field

        real(dp) :: share, along(3)
        integer :: i

        acting%torque_magnetic = cross(self%gain*self%flowing_current(t), acting%field)
        acting%torque_thrusters = 0
        share = control_share(self, t)
        if (self%settings%rod_control .and. share > 0) then
            call self%control%act(y, self%inertia, acting%field, acting%control_moment, along)
            acting%control_moment = share*acting%control_moment
            acting%torque_magnetic = acting%torque_magnetic + cross(acting%control_moment, acting%field)
            acting%torque_thrusters = share*along
        else if (share > 0) then
            acting%torque_thrusters = share*self%control%wanted_torque(y, self%inertia)
        end if
        do i = 1, size(self%firings)
            acting%torque_thrusters = acting%torque_thrusters + &
                                      share_of(self%firings(i)%time, t, self%window)*TORQUES(:, self%firings(i)%pair)
        end do
    end subroutine actuate

    !> The controller's currents at a time and state, from the field alone: all loads take many times as long. 0 if it acts without.
    pure function control_current(self, t, y) result(current)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t                   !! s
        real(dp), intent(in) :: y(STATE_SIZE)       !! State
        real(dp) :: current(3)                      !! mA

        real(dp) :: earth_from_inertial(3, 3), quaternion(4), field(3), moment(3), along(3)

        current = 0
        if (.not. self%settings%rod_control) return
        earth_from_inertial = self%earth%from_inertial(t)
        call self%field%evaluate(transformed(earth_from_inertial, y(POSITION)), field)
        quaternion = y(ATTITUDE)
        field = transformed(rotation_matrix(quaternion/norm2(quaternion)), transformed_back(earth_from_inertial, field))
        call self%control%act(y, self%inertia, field, moment, along)
        current = control_share(self, t)*moment/self%gain
    end function control_current

    !> How much of a window about a time a firing fills; of an instant 1 or 0.
    pure real(dp) function share_of(begin, t, window) result(share)
        real(dp), intent(in) :: begin, t, window    !! s

        if (window > 0) then
            share = max(0.0_dp, min(t + window/2, begin + FIRING_TIME) - max(t - window/2, begin))/window
        else
            share = merge(1, 0, t >= begin .and. t < begin + FIRING_TIME)
        end if
    end function share_of

    !> The force along y that firings leave over, N.
    pure real(dp) function thrust(self, t)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        integer :: i

        thrust = 0
        do i = 1, size(self%firings)
            thrust = thrust + THRUSTER*self%firings(i)%mismatch*share_of(self%firings(i)%time, t, self%window)
        end do
    end function thrust

    !> How much the controller acts: 0 in and around the spans.
    pure real(dp) function control_share(self, t) result(share)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        real(dp) :: away
        integer :: i

        share = 1
        do i = 1, size(self%spans)
            away = max(self%spans(i)%start - FREE - t, t - self%spans(i)%start - self%spans(i)%duration - FREE)
            away = max(0.0_dp, min(1.0_dp, away/TAKE_OVER))
            share = min(share, away**3*(10 - 15*away + 6*away**2))
        end do
    end function control_share

    !> The first time after t at which a span or a firing begins or ends, or a current jumps, s.
    pure real(dp) function next_edge(self, t) result(edge)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        real(dp) :: edges(2*(size(self%spans) + size(self%firings)) + 4)

        associate (spans => self%spans, late => self%settings%torque_delay)
            edges = [spans%start + late, spans%start + spans%duration + late, self%firings%time, &
                     self%firings%time + FIRING_TIME, held_tag(self, t - late) + self%tag_interval + late, next_zeros(self, t)]
            if (.not. self%settings%staircase) edges(size(edges) - 3) = huge(edge)
        end associate
        edge = minval(edges, mask=edges > t)
    end function next_edge

    !> The next times at which square currents change their signs, s.
    pure function next_zeros(self, t) result(zeros)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s
        real(dp) :: zeros(3)                !! huge, where there is none

        integer :: number

        zeros = huge(t)
        number = in_span(self%spans, t - self%settings%torque_delay)
        if (number == 0 .or. self%settings%staircase .or. self%settings%waveform /= 'square') return
        associate (span => self%spans(number), late => self%settings%torque_delay)
            where (span%cycles > 0) zeros = span%start + late + span%duration/(TWO_PI*span%cycles)* &
                (PI*(floor((TWO_PI*span%cycles*(t - late - span%start)/span%duration + span%phase)/PI) + 1) - span%phase)
        end associate
    end function next_zeros

    !> The span that a time lies in; 0: none.
    pure integer function in_span(spans, t) result(number)
        type(level1_span_settings_t), intent(in) :: spans(:)
        real(dp), intent(in) :: t           !! s

        do number = size(spans), 1, -1
            if (t >= spans(number)%start .and. t < spans(number)%start + spans(number)%duration) return
        end do
    end function in_span

    !> The tag whose currents are held at a time.
    pure real(dp) function held_tag(self, t) result(tag)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        tag = self%tag + floor((t - self%tag)/self%tag_interval)*self%tag_interval
    end function held_tag

    !> The currents that flow: those of a tag, later by the delay.
    pure function flowing_current(self, t) result(current)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s
        real(dp) :: current(3)              !! mA

        real(dp) :: told

        told = t - self%settings%torque_delay
        if (self%settings%staircase) told = held_tag(self, told)
        current = self%tagged_current(told)
    end function flowing_current

    !> Sines or squares in a span, slow currents and tones between.
    pure function tagged_current(self, t) result(current)
        class(day_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! Of the tag, s
        real(dp) :: current(3)              !! mA

        integer :: number

        number = in_span(self%spans, t)
        if (number == 0) then
            current = self%settings%science_current*(PARTS(1)*sin(TWO_PI*(t/SLOWEST(1) + self%science(1, :))) + &
                                            PARTS(2)*sin(TWO_PI*(t/SLOWEST(2) + self%science(2, :))) + &
                                            PARTS(3)*(2*self%science(3, :) - 1)) + &
                      self%settings%whisper*sin(TWO_PI*self%settings%whisper_frequency*t + self%settings%whisper_phase)
            return
        end if
        associate (span => self%spans(number))
            current = sin(TWO_PI*span%cycles*(t - span%start)/span%duration + span%phase)
            if (self%settings%waveform == 'square') current = sign(1.0_dp, current)
            current = span%amplitude*current
        end associate
    end function tagged_current
end module gracecg_level1_day_dynamics
