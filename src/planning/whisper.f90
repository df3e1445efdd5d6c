!> Weak tones that the torque rods have all the time, while the satellite goes on with its work: what they tell of the CG offset
!> after a revolution, a day, a week, and which are best within limits.
!>
!> In the field B of the nominal attitude rod k, with the moment m cos(2 pi f t) along e_k, turns the satellite by
!>
!>     wd = J^-1 (e_k x B) m cos(2 pi f t),    theta = -wd/(2 pi f)^2,
!>
!> and in phase with it the accelerometer has
!>
!>     a = wd x d + L_k m cos(2 pi f t) + (0, k_y, 0) theta_z - (0, 0, k_z) theta_y,
!>
!> L_k the leakage of the rod, k_y and k_z the push of the air on a turned satellite (docs/theory.md, 18.8). An amplitude in noise
!> of the one-sided density S is known to S/T after the time T. Tones of different frequencies do not disturb each other; along
!> the orbit B turns, by which d and L are told apart. What acts in quadrature (leakage by the rate of the current) looks like
!> neither. Gains of the rods are taken as known: the angular channels of an accelerometer tell them to 1e-4 in a day;
!> so is the scale of the accelerometer, whose error is the same part of d.
module gracecg_planning_whisper
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, SECONDS_PER_DAY
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_text, only: real_text
    use gracecg_base_vectors, only: cross, cross_matrix, inverse_3x3
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_dynamics, only: loads_t
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN, USUAL_LEAKAGE
    use gracecg_spacecraft_torque_rods, only: rod_direction
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_offset_bound, only: invert_information
    implicit none
    private
    public :: whisper_limits_t, whisper_tone_t, whisper_plan_t, plan_whisper, TIMES

    real(dp), parameter :: STEP = 30                !! Between the places of the orbit, s
    real(dp), parameter :: GRID = 5e-3_dp           !! Of frequencies that are tried, Hz
    real(dp), parameter :: APART = 0.01_dp          !! Of frequencies at least, Hz: three periods of arcs of 300 s
    real(dp), parameter :: LIFT = 3e-7_dp           !! Standard deviation of k_y, k_z, m/s^2: as `lift_sigma` of Level-1
    integer, parameter :: UNKNOWN = 14              !! d, L by rod and axis, k_y, k_z
    character(10), parameter :: TIMES(3) = [character(10) :: 'revolution', 'day', 'week']    !! After which d is judged

    type :: whisper_limits_t
        !! Of the tones
        real(dp) :: moment = 1                      !! Of a rod, A m^2
        real(dp) :: band(2) = [0.05_dp, 0.15_dp]    !! Hz: where neither gravity nor the noise of ranging is
        real(dp) :: turn = 1e-5_dp                  !! About any axis, all rods together, rad
        real(dp) :: tilt_coupling = 200e-6_dp       !! Of a turn into the range, m/rad
        real(dp) :: range = 1e-9_dp                 !! Error of the range, m
    end type whisper_limits_t

    type :: whisper_tone_t
        !! Of one rod
        real(dp) :: frequency = 0                   !! Hz
        real(dp) :: moment = 0                      !! A m^2
        real(dp) :: turn(3) = 0                     !! Largest amplitude about the axes, rad
    end type whisper_tone_t

    type :: whisper_plan_t
        !! The best tones
        type(whisper_tone_t) :: tones(3)            !! Of rods x, y, z
        real(dp) :: turn = 0                        !! Largest about an axis, all tones at once, rad
        real(dp) :: range = 0                       !! What it makes in the range, m
        real(dp) :: sigma(3, size(TIMES)) = 0       !! Of d after each of TIMES, leakage and lift estimated, m
        real(dp) :: sigma_alone(3, size(TIMES)) = 0 !! The same by the noise alone, m
    end type whisper_plan_t

contains

    !> The tones by which the worst axis is known best after a day. Fails as the orbit does, when there are no rods or they do not
    !> bear the moment, when the band is empty, too narrow for three tones, or beyond the sampling, or the noise has no level.
    subroutine plan_whisper(case, limits, plan, error)
        type(case_t), intent(in) :: case
        type(whisper_limits_t), intent(in) :: limits
        type(whisper_plan_t), intent(out) :: plan
        type(error_t), allocatable, intent(out) :: error

        type(operator_knowledge_t) :: knowledge
        type(nominal_orbit_t) :: orbit
        type(coloured_noise_t) :: noise(3)
        type(loads_t) :: acting
        real(dp), allocatable :: field(:, :), day(:, :, :, :)   ! in body axes along the nominal flight, T
        type(whisper_tone_t), allocatable :: tones(:, :)
        real(dp) :: frequency, sigma(3), best
        integer :: i, j, k, n, chosen(3)

        knowledge = operator_knowledge(case, case%operator)
        if (knowledge%rods%direct) then
            call fail(error, 'tones all the time are for torque rods; case '//trim(case%name)//' has torquers')
        else if (limits%moment > knowledge%rods%largest_moment) then
            call fail(error, 'tones of '//real_text(limits%moment)//' A m^2: a rod of case '//trim(case%name)//' bears '// &
                      real_text(knowledge%rods%largest_moment)//' (largest_moment of &rods)')
        end if
        if (allocated(error)) return
        n = 1 + floor((limits%band(2) - limits%band(1))/GRID + 1e-6_dp)
        if (.not. limits%band(1) > 0 .or. n < 1 + 2*nint(APART/GRID) .or. &
            .not. limits%band(2) < 0.5_dp/knowledge%accelerometer_interval) then
            call fail(error, 'band of frequencies: '//real_text(limits%band(1))//' to '//real_text(limits%band(2))// &
                      ' Hz; three tones need 0.02 Hz, above 0 and below half of the sampling frequency')
            return
        end if
        call new_nominal_orbit(case, orbit, error, revolutions=ceiling(SECONDS_PER_DAY/5500), interval=STEP)
        if (allocated(error)) return
        allocate (field(3, nint(SECONDS_PER_DAY/STEP)))
        do i = 1, size(field, 2)
            call orbit%dynamics%loads((i - 1)*orbit%interval, orbit%state(:, i - 1), acting)
            field(:, i) = acting%field
        end do
        do k = 1, 3
            noise(k) = coloured_noise(knowledge%accelerometer_noise(k), knowledge%accelerometer_interval, error)
            if (.not. allocated(error) .and. .not. noise(k)%spectrum(limits%band(1)) > 0) &
                call fail(error, 'the noise level of the accelerometer has to be positive')
            if (allocated(error)) return
        end do
        allocate (tones(n, 3), day(UNKNOWN, UNKNOWN, n, 3))
        do i = 1, n
            frequency = min(limits%band(1) + (i - 1)*GRID, limits%band(2))
            do k = 1, 3
                call set_tone(knowledge, limits, field, k, frequency, tones(i, k))
                call gather(knowledge, field, k, tones(i, k), 2*noise%spectrum(frequency), day(:, :, i, k))
            end do
        end do
        best = huge(best)
        do i = 1, n
            do j = 1, n
                if (abs(i - j)*GRID < APART - epsilon(1.0_dp)) cycle
                do k = 1, n
                    if (min(abs(i - k), abs(j - k))*GRID < APART - epsilon(1.0_dp)) cycle
                    call sigma_of(day(:, :, i, 1) + day(:, :, j, 2) + day(:, :, k, 3), sigma)
                    if (.not. maxval(sigma) < best) cycle
                    best = maxval(sigma)
                    chosen = [i, j, k]
                end do
            end do
        end do
        if (.not. best < huge(best)) then
            call fail(error, 'tones of the rods do not determine the offset')
            return
        end if
        plan%tones = [(tones(chosen(k), k), k=1, 3)]
        plan%turn = maxval([(sum([(plan%tones(k)%turn(i), k=1, 3)]), i=1, 3)])
        plan%range = limits%tilt_coupling*plan%turn
        call judge_times()

    contains

        !> What the chosen tones reach.
        subroutine judge_times()
            real(dp) :: information(UNKNOWN, UNKNOWN, size(TIMES)), one(UNKNOWN, UNKNOWN), covariance(3, 3)
            integer :: rod, time

            information = 0
            do rod = 1, 3
                call gather(knowledge, field(:, :nint(orbit%revolution/STEP)), rod, plan%tones(rod), &
                            2*noise%spectrum(plan%tones(rod)%frequency), one)
                information(:, :, 1) = information(:, :, 1) + one
                information(:, :, 2) = information(:, :, 2) + day(:, :, chosen(rod), rod)
            end do
            information(:, :, 3) = 7*information(:, :, 2)
            do time = 1, size(TIMES)
                call sigma_of(information(:, :, time), plan%sigma(:, time))
                call invert_information(information(:3, :3, time), covariance, plan%sigma_alone(:, time))
            end do
        end subroutine judge_times
    end subroutine plan_whisper

    !> The tone of a rod at a frequency, as strong as the limits allow; a third of what all may turn is its share.
    subroutine set_tone(knowledge, limits, field, rod, frequency, tone)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(whisper_limits_t), intent(in) :: limits
        real(dp), intent(in) :: field(:, :)     !! Body axes, T
        integer, intent(in) :: rod
        real(dp), intent(in) :: frequency       !! Hz
        type(whisper_tone_t), intent(out) :: tone

        real(dp) :: allowed
        integer :: k

        tone%frequency = frequency
        do k = 1, size(field, 2)
            tone%turn = max(tone%turn, abs(angular_acceleration(knowledge, rod, field(:, k))))
        end do
        tone%turn = tone%turn/(TWO_PI*frequency)**2
        allowed = min(limits%turn, limits%range/limits%tilt_coupling)/3
        tone%moment = min(limits%moment, allowed/maxval(tone%turn))
        tone%turn = tone%moment*tone%turn
    end subroutine set_tone

    !> d omega/dt by 1 A m^2 of a rod, rad/s^2.
    function angular_acceleration(knowledge, rod, field) result(omega_dot)
        type(operator_knowledge_t), intent(in) :: knowledge
        integer, intent(in) :: rod
        real(dp), intent(in) :: field(3)        !! Body axes, T
        real(dp) :: omega_dot(3)

        omega_dot = matmul(inverse_3x3(knowledge%inertia), cross(rod_direction(knowledge%rods, rod), field))
    end function angular_acceleration

    !> What a tone says of the unknowns along the orbit.
    subroutine gather(knowledge, field, rod, tone, density, information)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: field(:, :)     !! Body axes, (3, places), T
        integer, intent(in) :: rod
        type(whisper_tone_t), intent(in) :: tone
        real(dp), intent(in) :: density(3)      !! Of the noise, one-sided, m^2 s^-4/Hz
        real(dp), intent(out) :: information(UNKNOWN, UNKNOWN)

        real(dp) :: rows(3, UNKNOWN), omega_dot(3), turn(3)
        integer :: axis, i, k

        information = 0
        rows = 0
        do axis = 1, 3
            rows(axis, 3*rod + axis) = tone%moment
        end do
        do k = 1, size(field, 2)
            omega_dot = tone%moment*angular_acceleration(knowledge, rod, field(:, k))
            turn = -omega_dot/(TWO_PI*tone%frequency)**2
            rows(:, :3) = cross_matrix(omega_dot)
            rows(2, UNKNOWN - 1) = turn(3)
            rows(3, UNKNOWN) = -turn(2)
            do i = 1, UNKNOWN
                information(:, i) = information(:, i) + STEP*matmul(rows(:, i)/density, rows)
            end do
        end do
    end subroutine gather

    !> Of d, with leakage and lift as they are known beforehand; huge where they do not tell.
    subroutine sigma_of(information, sigma)
        real(dp), intent(in) :: information(UNKNOWN, UNKNOWN)
        real(dp), intent(out) :: sigma(3)       !! m

        type(error_t), allocatable :: singular
        real(dp) :: matrix(UNKNOWN, UNKNOWN), covariance(UNKNOWN, UNKNOWN), x(UNKNOWN), condition
        integer :: k

        matrix = information
        do k = 4, UNKNOWN
            matrix(k, k) = matrix(k, k) + 1/merge(LIFT, USUAL_LEAKAGE(1)/USUAL_ROD_GAIN, k > UNKNOWN - 2)**2
        end do
        sigma = huge(1.0_dp)
        call solve_normal_equations(matrix, spread(0.0_dp, 1, UNKNOWN), x, covariance, condition, singular)
        if (.not. allocated(singular)) sigma = sqrt([(covariance(k, k), k=1, 3)])
    end subroutine sigma_of
end module gracecg_planning_whisper
