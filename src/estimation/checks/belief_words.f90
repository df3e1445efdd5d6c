!> What the tests of the operator's beliefs have found, in words.
module gracecg_estimation_belief_words
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_statistics, only: order_of
    use gracecg_base_text, only: string_t, integer_text, rounded_text
    use gracecg_observations_parameters, only: ROD_GAIN, ROD_GAINS, belief_subject, BELIEF_UNIT, BELIEF_SIZE
    use gracecg_estimation_belief, only: ALTERATIONS
    use gracecg_estimation_belief_report, only: belief_report_t, explanation_t, NOISE_SUBJECTS, OF_STAR_CAMERA, &
        LINES, FIELD_AGAINST_MODEL, HEADS_APART, OF_VALUE, OF_ALTERATION, CONTRADICTED, UNTESTED
    implicit none
    private
    public :: say_counts, say_contradiction, say_undetected, say_untested, say_value, say_failed_tests, is_larger_alike, &
        FAILED_TESTS

    integer, parameter :: MOST_NAMED = 4    !! Beliefs that cannot be tested
    character(*), parameter :: FAILED_TESTS = 'what the setup says could not be tested: '   !! A warning begins so, if so

contains

    !> How many beliefs were tested, and with what result.
    subroutine say_counts(report, text)
        type(belief_report_t), intent(in) :: report
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        associate (values => report%values%state, noises => report%noises%state)
            text = integer_text(size(values) + size(noises))//' tested: '// &
                integer_text(count(values == CONTRADICTED) + count(noises == CONTRADICTED))//' contradicted, '// &
                integer_text(count(values == UNTESTED))//' cannot be tested here'
        end associate
        if (.not. report%signs_known) text = text//', nor can the sign of the accelerometer'
    end subroutine say_counts

    !> What contradicts the operator's beliefs, and what would explain it; empty if nothing does.
    subroutine say_contradiction(report, text)
        type(belief_report_t), intent(in) :: report
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        character(:), allocatable :: part
        integer :: i

        text = ''
        if (.not. report%has_contradiction()) return
        call say_worst(report, part)
        text = 'the data contradict what the setup says ('//part//')'
        call say_lines(report, part)
        text = text//part
        if (report%lost_channel /= '') then
            text = text//'; '//trim(report%lost_channel)
            return
        end if
        if (air_may_be_it(report)) text = text//'; the cause may be forces of the air, which so quiet an accelerometer feels '// &
            'better than they are modelled: calibrate higher, or elsewhere on the orbit'
        if (size(report%explanations) == 0) then
            text = text//'; no single wrong belief of those that were tried explains them'
            return
        end if
        if (is_too_long(report)) then
            text = text//'; no single wrong belief explains that, and the rotation does not fit: torques that are no constant '// &
                'over the arc of '//rounded_text(report%arc, 4)//' s may be the cause; estimate it in shorter arcs '// &
                '(--algorithm optimal --arc 60)'
            return
        end if
        text = text//'; they fit if '
        do i = 1, size(report%explanations)
            if (i > 1) text = text//', or if '
            call say_explanation(report, report%explanations(i), part)
            text = text//part
        end do
        if (.not. report%explanations(1)%complete) text = text//'; even then something is contradicted'
    end subroutine say_contradiction

    !> Is it the length of the arc, and no belief, that the data contradict? Where nothing explains all, and the star camera's
    !> residuals are no noise, over an arc of more than twice the report's 60 s, for which its constant torque was meant.
    pure logical function is_too_long(report)
        type(belief_report_t), intent(in) :: report

        real(dp), parameter :: LONG = 120       ! s
        integer :: i

        is_too_long = report%arc > LONG .and. .not. any(report%explanations%complete) .and. &
            any([(any(OF_STAR_CAMERA == report%noises(i)%subject) .and. report%noises(i)%state == CONTRADICTED, &
                  i=1, size(report%noises))])
    end function is_too_long

    !> Are the residuals of an accelerometer that feels more than the model has what is farthest off?
    pure logical function air_may_be_it(report)
        type(belief_report_t), intent(in) :: report

        air_may_be_it = .false.
        if (.not. report%feels_air .or. size(report%noises) == 0) return
        associate (worst => report%noises(maxloc(abs(report%noises%score), 1)))
            air_may_be_it = all([OF_STAR_CAMERA, FIELD_AGAINST_MODEL, HEADS_APART] /= worst%subject) .and. &
                abs(worst%score) > maxval(abs([0.0_dp, report%values%fair]))
        end associate
    end function air_may_be_it

    !> Lines in the residuals' spectra that contradict, and whether a rod has their frequency; samples that do not belong
    !> together; empty if there are none.
    subroutine say_lines(report, text)
        type(belief_report_t), intent(in) :: report
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        integer :: i

        text = ''
        do i = 1, size(report%noises)
            associate (test => report%noises(i))
                if (test%state /= CONTRADICTED) cycle
                if (test%subject == FIELD_AGAINST_MODEL) text = text//'; magnetometer, orbit or star camera may be of '// &
                    'another satellite or time'
                if (.not. any(LINES == test%subject)) cycle
                text = text//'; a '//trim(NOISE_SUBJECTS(test%subject))//' at '//rounded_text(test%frequency, 4)//' Hz'
                if (test%at_a_rod) text = text//', the frequency of a rod'
            end associate
        end do
    end subroutine say_lines

    !> The beliefs that cannot be tested here, those with the largest effects first; empty if there are none.
    subroutine say_untested(report, text)
        type(belief_report_t), intent(in) :: report
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        integer, allocatable :: places(:)
        integer :: i, n

        text = ''
        places = pack([(i, i=1, size(report%values))], report%values%state == UNTESTED)
        places = places(order_of([(-maxval(abs(report%values(places(i))%within)), i=1, size(places))]))
        n = size(places)
        do i = 1, min(n, MOST_NAMED)
            if (i > 1) text = text//', '
            associate (test => report%values(places(i)))
                text = text//trim(test%subject)//' ('//rounded_text(maxval(abs(test%within))/MILLIMETRE, 2)//' mm)'
            end associate
        end do
        if (n > MOST_NAMED) text = text//' and '//integer_text(n - MOST_NAMED)//' more'
        if (report%signs_known) return
        if (text /= '') text = text//'; '
        text = text//'the sign of the accelerometer (all its axes turned would turn d: no calibration tells; a small trim '// &
            'does, then set signs_known)'
    end subroutine say_untested

    !> Why the tests that were asked for could not be made, by the warnings; empty if they were not asked for.
    subroutine say_failed_tests(warnings, text)
        type(string_t), intent(in) :: warnings(:)       !! Of an estimate without tests
        character(:), allocatable, intent(out) :: text  !! Words, without a full stop

        integer :: i

        text = ''
        do i = 1, size(warnings)
            if (index(warnings(i)%text, FAILED_TESTS) == 1) text = warnings(i)%text
        end do
    end subroutine say_failed_tests

    !> The belief with the largest score.
    subroutine say_worst(report, text)
        type(belief_report_t), intent(in) :: report
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        real(dp) :: of_values, of_noises

        of_values = maxval(abs([0.0_dp, report%values%fair]))
        of_noises = maxval(abs([0.0_dp, report%noises%score]))
        if (of_values >= of_noises) then
            text = trim(report%values(maxloc(abs(report%values%fair), 1))%subject)
        else
            text = trim(NOISE_SUBJECTS(report%noises(maxloc(abs(report%noises%score), 1))%subject))
        end if
        text = text//': '//rounded_text(max(of_values, of_noises), 3)//' sigma off'
    end subroutine say_worst

    !> An explanation, with what the offset would be.
    subroutine say_explanation(report, explanation, text)
        type(belief_report_t), intent(in) :: report
        type(explanation_t), intent(in) :: explanation
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        real(dp), parameter :: FAR_LESS = 0.3_dp    ! No instrument is so much better than its operator says
        character(48) :: subject
        integer :: i, axis

        select case (explanation%kind)
        case (OF_VALUE)
            subject = belief_subject(explanation%place)
            i = findloc(report%values%belief, explanation%place, 1)
            if (i > 0) subject = report%values(i)%subject       ! torquers are no rods
            call say_value(subject, explanation%place, explanation%value, explanation%sigma, text)
        case (OF_ALTERATION)
            text = trim(ALTERATIONS(explanation%place))
        case default
            text = 'the noise levels are not those of the setup ('//trim(NOISE_SUBJECTS(explanation%place))//': '// &
                rounded_text(explanation%value, 3)//' times in standard deviation, noise_level by its square)'
            if (explanation%value < FAR_LESS) then
                text = text//' or the samples are of another unit'
            else if (is_larger_alike(accelerometer_factors(report))) then
                text = text//', or all samples of the accelerometer are as many times too large (its unit, its scale), and d '// &
                    'with them: find out which, and correct noise or scale in the setup'
            else
                text = text//': correct it, or let the data tell it (&optimal noise = ''estimate'' /)'
            end if
        end select
        text = text//' (d would be'
        do axis = 1, 3
            text = text//' '//rounded_text(explanation%offset(axis)/MILLIMETRE, 3)
        end do
        text = text//' mm)'
    end subroutine say_explanation

    !> By how much the noise of the accelerometer's axes is more than believed, standard deviations by those; 1: not tested.
    pure function accelerometer_factors(report) result(factors)
        type(belief_report_t), intent(in) :: report
        real(dp) :: factors(3)

        integer :: i

        factors = 1
        do i = 1, size(report%noises)
            if (report%noises(i)%subject <= 3) factors(report%noises(i)%subject) = report%noises(i)%factor
        end do
    end function accelerometer_factors

    !> Is the noise of all axes larger by one factor? So are samples that are too large.
    pure logical function is_larger_alike(factors)
        real(dp), intent(in) :: factors(3)      !! Standard deviations, by those believed

        real(dp), parameter :: LARGER = 1.15_dp, ALIKE = 1.15_dp    ! Chosen: 600 samples tell a standard deviation to 3 %

        is_larger_alike = minval(factors) > LARGER .and. maxval(factors) < ALIKE*minval(factors)
    end function is_larger_alike

    !> 'the gain of rod y is 0.52 +/- 0.04 of that of the setup', 'the delay of rod y is 0.1 +/- 0.02 s more than
    !> the setup says'.
    subroutine say_value(subject, belief, value, sigma, text)
        character(*), intent(in) :: subject     !! Of the belief, in words
        integer, intent(in) :: belief           !! The parameter's place
        real(dp), intent(in) :: value, sigma    !! SI units
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        text = 'the '//trim(subject)//' is '
        if (belief == ROD_GAIN .or. any(ROD_GAINS == belief)) then
            text = text//rounded_text(1 + value, 3)//' +/- '//rounded_text(sigma, 2)//' of that of the setup'
        else
            associate (unit => BELIEF_SIZE(belief))
                text = text//rounded_text(abs(value)/unit, 3)//' +/- '//rounded_text(sigma/unit, 2)// &
                    trim(' '//BELIEF_UNIT(belief))//trim(merge(' more', ' less', value > 0))//' than the setup says'
            end associate
        end if
    end subroutine say_value

    !> What could be wrong by how much on each axis without any test seeing it.
    subroutine say_undetected(report, within, text)
        type(belief_report_t), intent(in) :: report
        logical, intent(in) :: within           !! If what the operator states holds
        character(:), allocatable, intent(out) :: text    !! Words, without a full stop

        real(dp) :: effect
        integer :: axis, place

        text = ''
        do axis = 1, 3
            place = merge(report%largest_within(axis), report%largest(axis), within)
            if (place == 0) cycle
            if (text /= '') text = text//', '
            associate (test => report%values(place))
                effect = abs(merge(test%within(axis), test%effect(axis), within))
                text = text//AXES(axis)//' '//rounded_text(effect/MILLIMETRE, 2)//' mm ('//trim(test%subject)//')'
            end associate
        end do
    end subroutine say_undetected
end module gracecg_estimation_belief_words
