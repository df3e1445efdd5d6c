!> What to do after a calibration, in words: the steps that follow from its verdict, with the commands that
!> help.
module gracecg_cli_calibration_advice
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_text, only: string_t, rounded_text
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_verdict, only: verdict_t, listed_axes, NOT_ZERO, &
        STEP_MEND, STEP_GIVE_NOISE, STEP_TRIM, STEP_LEAVE, STEP_REPEAT, STEP_LOWER_LIMIT, STEP_RECALIBRATE, STEP_TEST
    use gracecg_observations_parameters, only: belief_subject
    use gracecg_estimation_belief, only: testing_manoeuvre
    use gracecg_estimation_belief_report, only: UNTESTED
    implicit none
    private
    public :: advice_of

contains

    !> A sentence or two for each step.
    function advice_of(verdict, mass, solution) result(advice)
        type(verdict_t), intent(in) :: verdict
        real(dp), intent(in) :: mass                !! Of the satellite, kg
        type(solution_t), intent(in) :: solution
        type(string_t), allocatable :: advice(:)

        integer :: i

        allocate (advice(size(verdict%next_steps)))
        do i = 1, size(advice)
            associate (step => verdict%next_steps(i))
                select case (step%kind)
                case (STEP_MEND)
                    advice(i)%text = 'Mend what is marked with a cross, or leave the faulty samples out, and estimate '// &
                        'again; if that is not possible, repeat the calibration.'
                case (STEP_GIVE_NOISE)
                    advice(i)%text = 'Give the noise levels of the instruments in `setup.nml` and estimate again: '// &
                        'without them nobody can say which component may be trimmed.'
                case (STEP_TRIM)
                    advice(i)%text = trim_text(step%axes, mass, solution%offset)
                case (STEP_LEAVE)
                    advice(i)%text = 'Leave '//trim(listed_axes(step%axes))//' as it is: within '// &
                        rounded_text(NOT_ZERO, 2)//' sigma of zero.'
                case (STEP_REPEAT)
                    advice(i)%text = 'Repeat for '//trim(listed_axes(step%axes))//': this manoeuvre at this place '// &
                        'hardly shows it. Choose a place where the angular acceleration has another direction '// &
                        '(`gracecg timing`), or drive the rods out of phase, and calibrate again. Do not trim what is '// &
                        'not determined.'
                case (STEP_LOWER_LIMIT)
                    advice(i)%text = 'Take the sigmas for a lower limit: the residuals hold more than the '// &
                        'instruments'' noise. `gracecg montecarlo` with a case of this satellite tells the error that '// &
                        'such forces cause.'
                case (STEP_TEST)
                    advice(i)%text = test_text(solution)
                case (STEP_RECALIBRATE)
                    advice(i)%text = 'After the trim calibrate again: what is left should be within the sigmas and the '// &
                        'error of the mass balancing.'
                end select
            end associate
        end do
    end function advice_of

    !> Which manoeuvre would test what cannot be tested here, the belief with the largest effect first.
    function test_text(solution) result(text)
        type(solution_t), intent(in) :: solution
        character(:), allocatable :: text

        character(:), allocatable :: how
        integer :: i, worst

        text = 'Do not trim yet: what could not be tested may move the offset farther than is wanted.'
        associate (report => solution%beliefs)
            worst = 0
            do i = 1, size(report%values)
                if (report%values(i)%state /= UNTESTED) cycle
                if (worst > 0) then
                    if (maxval(abs(report%values(i)%effect)) <= maxval(abs(report%values(worst)%effect))) cycle
                end if
                worst = i
            end do
            if (worst > 0) then
                call testing_manoeuvre(report%values(worst)%belief, how)
                text = text//' The '//trim(belief_subject(report%values(worst)%belief))//' would be tested by '//how//'.'
            end if
            if (.not. report%signs_known) text = text//' The sign of the accelerometer is tested by no manoeuvre: move the '// &
                'masses by a small known part, calibrate again, see that the offset changed by it, and set `signs_known` in '// &
                'group `&a_priori` of setup.nml.'
        end associate
    end function test_text

    function trim_text(chosen, mass, offset) result(text)
        logical, intent(in) :: chosen(3)
        real(dp), intent(in) :: mass, offset(3)     !! kg; m
        character(:), allocatable :: text

        character(:), allocatable :: moves, moments, comma
        integer :: axis

        moves = ''
        moments = ''
        comma = ''
        do axis = 1, 3
            if (.not. chosen(axis)) cycle
            moves = moves//comma//signed(offset(axis)/MILLIMETRE)//' mm along '//AXES(axis)
            moments = moments//comma//signed(mass*offset(axis)/MILLIMETRE)//' kg mm'
            comma = ', '
        end do
        text = 'Trim: move the centre of mass by '//moves//' (towards the proof mass; the offset changes by the '// &
            'negative of it). With '//rounded_text(mass, 4)//' kg these are mass moments of '//moments//'.'
    end function trim_text

    !> A number with its sign.
    function signed(value) result(text)
        real(dp), intent(in) :: value
        character(:), allocatable :: text

        text = rounded_text(value, 3)
        if (value > 0) text = '+'//text
    end function signed
end module gracecg_cli_calibration_advice
