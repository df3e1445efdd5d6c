!> Which parameters fits estimate, and what is known of them beforehand.
module gracecg_estimation_parameters
    use gracecg_base_kinds, only: dp
    use gracecg_base_coloured_noise, only: ONE_SIDED
    use gracecg_observations_knowledge, only: operator_knowledge_t, USUAL_DRAG
    use gracecg_observations_parameters
    implicit none
    private
    public :: ALWAYS_ESTIMATED, OF_STATE, a_priori_sigmas, conceivable_errors, feels_lift, feels_air

    integer, parameter :: ALWAYS_ESTIMATED(*) = [ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS]
    !! Parameters of every fit; `optimal` adds to them
    integer, parameter :: OF_STATE(15) = [OFFSET, DRIFT, BIAS, RATE, ATTITUDE_ANGLES]
    !! Those of the solution's state, in its order
    real(dp), parameter :: USUAL_ARC = 60           !! Of the cases of CSR-TM-00-01, s
    real(dp), parameter :: USUAL_BEND = 5e-11_dp
    !! Standard deviation of each of FORCE_BENDS, m/s^2. Fitted, as USUAL_SIDE_FORCE is, to the six cases of CSR-TM-00-01:
    !! with these two the mean normalised square of the errors of `optimal` is near 3 there, and its RMS error grows by some
    !! per cent (docs/validation.md). The forces themselves bend by up to 4e-10 m/s^2, most of which the offset does not feel
    real(dp), parameter :: USUAL_WIND = 0.013_dp
    !! Standard deviation of AIRFLOW_TURN, rad: 100 m/s RMS across polar orbits (data/wind_hwm93_1989-01-02.txt)
    real(dp), parameter :: USUAL_SIDE_FORCE = 7e-7_dp
    !! Standard deviation of each of SIDE_FORCE, m/s^2/rad: fitted as USUAL_BEND; some 2e-6 acts in case 1, less in the others
    real(dp), parameter :: QUIET = 3e-21_dp
    !! Two-sided level of the noise across the flight below which the lift is seen, m^2 s^-4/Hz, chosen: a third of the report's,
    !! where a minute does not show it. At 4.5e-22, 420 km up, the mean normalised square without it is 11.4, with it 2.6
    real(dp), parameter :: USUAL_LIFT = 4e-7_dp
    !! Standard deviation of LIFT, m/s^2, fitted to one small satellite 420 km up, noise 4.5e-22: with 3e-7 (`lift_sigma` of
    !! Level-1) the mean normalised square is 3.8, with 1e-6 0.8
    real(dp), parameter :: USUAL_LIGHT = 1e-7_dp            !! Of GRACE's satellites, m/s^2: section 6 of docs/theory.md
    real(dp), parameter :: USUAL_TILT = 5e-8_dp
    !! Standard deviation of TILT, m/s^2, half of the light: fitted to the worst of four places 500 km up, three accelerometers of
    !! 1e-22: mean normalised squares without it up to 24, with it 0.3 to 2.9, with 1e-7 0.2 to 1.1
    real(dp), parameter :: USUAL_TURNING = 1.1e-3_dp
    !! Of a satellite that points to the Earth, rad/s: by so much the Sun's light turns against the body

contains

    !> How well the operator knows the parameters beforehand: standard deviations by place, 0 where nothing
    !> is known. They are a-priori knowledge of what is estimated, and limits of what is only considered.
    pure function a_priori_sigmas(knowledge) result(sigmas)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp) :: sigmas(PARAMETERS)      !! SI units

        integer :: i

        sigmas = 0
        sigmas(SCALE_FACTORS) = knowledge%a_priori%aged_scale_sigmas()
        sigmas(LINE_SCALES) = [knowledge%line%scale_sigma, knowledge%line%scale_sigma]
        sigmas(ROD_GAIN) = knowledge%a_priori%sigma_rod_gain
        associate (several => knowledge%line%number > 1)        ! they see the rotation, and what makes it
            if (several .or. knowledge%rods%direct) sigmas(ROD_GAINS) = knowledge%a_priori%sigma_rod_gain
            if (several) sigmas(TORQUE_BENDS) = knowledge%a_priori%sigma_torque
        end associate
        sigmas(FIELD_BIAS) = knowledge%a_priori%sigma_magnetometer_bias
        sigmas(INERTIA) = knowledge%a_priori%sigma_inertia*minval([(knowledge%inertia(i, i), i=1, 3)])
        sigmas(TORQUE_CHANGE) = knowledge%a_priori%sigma_torque
        sigmas(FORCE_BENDS) = force_size(knowledge)*USUAL_BEND*max(1.0_dp, knowledge%duration/USUAL_ARC)**BEND_DEGREE
        sigmas(AIRFLOW_TURN) = USUAL_WIND
        sigmas(SIDE_FORCE) = force_size(knowledge)*USUAL_SIDE_FORCE
        sigmas(LIFT) = force_size(knowledge)*USUAL_LIFT
        ! A slow swing takes the lift for an offset: no more of it is expected than of the air's force that is stated
        if (knowledge%rods%direct .and. knowledge%a_priori%drag > 0) sigmas(LIFT) = knowledge%a_priori%drag/USUAL_DRAG*USUAL_LIFT
        sigmas(TILT) = force_size(knowledge)*USUAL_TILT
        associate (turn => USUAL_TURNING*knowledge%duration/2, light_size => force_size(knowledge)*USUAL_LIGHT)
            sigmas(LIGHT(4:6)) = light_size*turn
            sigmas(LIGHT(7:9)) = light_size*turn**2/2
        end associate
    end function a_priori_sigmas

    !> How much larger than in the cases of CSR-TM-00-01 the forces are that are no straight line: as the acceleration itself.
    pure real(dp) function force_size(knowledge)
        type(operator_knowledge_t), intent(in) :: knowledge

        force_size = max(1.0_dp, knowledge%a_priori%drag/USUAL_DRAG)
    end function force_size

    !> Whether an instrument is so quiet, for the drag that there is, that the lift shows; or the satellite may swing as
    !> torquers make it, by milliradians for minutes: such a line shows it in any noise (a swing of 200 s in 1e-20 at the twelve
    !> places of docs/validation.md: mean normalised squares without it 712).
    pure logical function feels_lift(knowledge)
        type(operator_knowledge_t), intent(in) :: knowledge

        feels_lift = knowledge%rods%direct .or. is_quiet(knowledge, force_size(knowledge))
    end function feels_lift

    !> Whether an instrument is so quiet, for the drag that is stated or else usual, that it may show more than the model of the
    !> air's forces has.
    pure logical function feels_air(knowledge)
        type(operator_knowledge_t), intent(in) :: knowledge

        feels_air = is_quiet(knowledge, merge(knowledge%a_priori%drag/USUAL_DRAG, 1.0_dp, knowledge%a_priori%drag > 0))
    end function feels_air

    pure logical function is_quiet(knowledge, size)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: size        !! Of the forces, as force_size

        associate (noise => knowledge%accelerometer_noise(2:3))
            is_quiet = any(noise%level > 0 .and. noise%level/merge(2, 1, noise%sides == ONE_SIDED) < QUIET*size**2)
        end associate
    end function is_quiet

    !> The largest errors that agree with what the operator states: three standard deviations, but no more than any error;
    !> an interchange of axes is none once they have been confirmed. Rods follow a quartz. By place, SI units.
    pure function conceivable_errors(knowledge, stated) result(errors)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in), optional :: stated(:)     !! Other standard deviations, by place; 0: what `knowledge` says
        real(dp) :: errors(PARAMETERS)

        real(dp), parameter :: SIGMAS = 3
        real(dp), parameter :: QUARTZ = 1e-6_dp     ! Of the rods' frequencies, Hz: 1e-5 of 0.1 Hz, ours
        real(dp) :: sigmas_of(PARAMETERS)

        sigmas_of = a_priori_sigmas(knowledge)
        associate (known => knowledge%a_priori)
            sigmas_of(ROD_GAINS) = known%sigma_rod_gain
            sigmas_of(ROD_TURNS) = known%sigma_directions(1)
            sigmas_of(ACCELEROMETER_TURN) = known%sigma_directions(2)
            sigmas_of([FIELD_TURN, FIELD_SHEARS]) = known%sigma_directions(3)
            sigmas_of(FIELD_SCALES) = known%sigma_magnetometer_scale
            sigmas_of([MOUNTING_1, MOUNTING_2]) = known%sigma_mounting
            sigmas_of([ROD_DELAYS, ALL_RODS_DELAY, ACCELEROMETER_DELAYS, FIELD_DELAY, STAR_CAMERA_DELAY]) = known%sigma_delays
            sigmas_of([ROD_FREQUENCIES, ALL_RODS_FREQUENCY]) = QUARTZ
            if (present(stated)) where (stated > 0) sigmas_of = stated
            errors = LARGEST_ERROR
            where (sigmas_of > 0) errors = min(errors, SIGMAS*sigmas_of)
            if (known%signs_known) errors(INTERCHANGES) = 0
        end associate
    end function conceivable_errors
end module gracecg_estimation_parameters
